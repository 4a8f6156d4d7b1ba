// Solves the contact problem by sweeps of blocked projected Gauss-Seidel (cpu_reference/visit_contact.hpp) in the fixed
// order of colours: pairs of one colour share no movable body, so that their order within it cannot matter.
#pragma once

#include "cpu_reference/joints/visit_joint.hpp"
#include "cpu_reference/visit_contact.hpp"

namespace lockstep::reference {

template <class real>
void solve_constraints(Buffers<real>& buffers, const StepParams<real>& params) {
  if (step_is_void(buffers.counters)) return;
  for (u32 sweep = 0; sweep < params.iterations; ++sweep) {
    sweep_joints(JointPurpose::solve, buffers);
    for_each_contact_slot(buffers, [&](const BlockBodies& bodies, u32 row, u32 lane) {
      const ContactBlock<real>& block = buffers.contact_blocks[row];
      visit_contact(block, block.bias[lane], softness_of(buffers, row, lane), buffers.impulse_blocks[row],
                    bodies.kind[lane], lane, buffers.motions[bodies.body_a[lane]],
                    buffers.motions[bodies.body_b[lane]]);
    });
  }
}

}  // namespace lockstep::reference
