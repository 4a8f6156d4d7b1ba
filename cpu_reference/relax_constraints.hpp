// After a sub-step has moved the bodies, takes back the velocity that soft contacts gave them only to push overlap
// apart (Catto, Solver2D, 2024: "relaxing"; Macklin et al., Small Steps in Physics Simulation, 2019, for the
// sub-steps): `relaxations` more sweeps over the colours, in which contacts that overlap ask for no more than u_n >= 0,
// and are hard. Contacts that are open or bounce keep their law. What one sweep leaves of those velocities is energy: a
// building trembles by it, and what trembles walks (docs/theory/solvers.md).
#pragma once

#include "cpu_reference/joints/couplings.hpp"
#include "cpu_reference/joints/solve_joint.hpp"
#include "cpu_reference/sweep_contacts.hpp"

namespace lockstep::reference {

template <class real>
void relax_constraints(Buffers<real>& buffers, const StepParams<real>& params) {
  if (step_aborted(buffers.counters)) return;
  for (u32 sweep = 0; sweep < params.relaxations; ++sweep) {
    sweep_joints(Purpose::relax, buffers);
    sweep_couplings(Purpose::relax, buffers);
    sweep_contacts(Purpose::relax, buffers);
  }
}

}  // namespace lockstep::reference
