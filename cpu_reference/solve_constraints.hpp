// Solves the contact problem by sweeps of blocked projected Gauss-Seidel (cpu_reference/visit_contact.hpp) in the fixed
// order of colours: pairs of one colour share no movable body, so that their order within it cannot matter. In scenes
// solved by Jacobi's method a sweep visits all pairs at once (cpu_reference/visit_parts.hpp), after the joints.
#pragma once

#include "cpu_reference/joints/visit_joint.hpp"
#include "cpu_reference/sweep_contacts.hpp"

namespace lockstep::reference {

template <class real>
void solve_constraints(Buffers<real>& buffers, const StepParams<real>& params) {
  if (step_is_void(buffers.counters)) return;
  for (u32 sweep = 0; sweep < params.iterations; ++sweep) {
    sweep_joints(Purpose::solve, buffers);
    sweep_contacts(Purpose::solve, buffers);
  }
}

}  // namespace lockstep::reference
