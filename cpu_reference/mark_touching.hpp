// Which contacts touch: those that push in some sub-step, and those that overlap after one. A ball that bounces within
// a step is never seen to overlap, and one that is let go where it overlaps does not push at once; both touch.
#pragma once

#include "cpu_reference/current_contact.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
void mark_touching(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    const Contact& contact = b.contacts[i];
    const ImpulseBlock<real>& impulses = b.impulse_blocks[b.contact_slots[i] / PACK];
    const Pose<real> pose_a = make_pose(b.positions[contact.body_a], b.orientations[contact.body_a]);
    const Pose<real> pose_b = make_pose(b.positions[contact.body_b], b.orientations[contact.body_b]);
    const CurrentContact<real> current = current_contact(b.contact_points[i], contact.normal, pose_a, pose_b);
    const bool before = params.substep > 0 && b.touched[i] != 0;
    b.touched[i] = before || impulses.normal[b.contact_slots[i] % PACK] > 0 || current.gap <= 0 ? 1 : 0;
  }
}

}  // namespace lockstep::reference
