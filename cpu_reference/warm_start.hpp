// Gives the bodies the impulses that the contacts start from, so that the solver only has to find the change since the
// last step.
#pragma once

#include "cpu_reference/joints/visit_joint.hpp"
#include "cpu_reference/visit_contact.hpp"

namespace lockstep::reference {

template <class real>
void warm_start(Buffers<real>& buffers, const StepParams<real>&) {
  if (step_is_void(buffers.counters)) return;
  start_joints(buffers);
  for_each_contact_slot(buffers, [&](const BlockBodies& bodies, u32 row, u32 lane) {
    push(contact_frame(buffers.contact_blocks[row], lane), bodies.kind[lane],
         impulse_of(buffers.impulse_blocks[row], lane), buffers.motions[bodies.body_a[lane]],
         buffers.motions[bodies.body_b[lane]]);
  });
}

}  // namespace lockstep::reference
