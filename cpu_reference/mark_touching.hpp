// Which contacts touch: those that push in some sub-step, and those that overlap after one. A ball that bounces within
// a step is never seen to overlap, and one that is let go where it overlaps does not push at once; both touch.
//
// Where it is wanted, also how fast the two sides of what begins to push came together along the normal, at the
// velocities with which the sub-step began: the fastest of those sub-steps. What pushed in the sub-step before goes on
// with a blow that has been told: a sub-step that foresees an impact lets the two come as far as they touch, and the
// next one stops them.
#pragma once

#include "cpu_reference/current_contact.hpp"
#include "cpu_reference/grid.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// Bits of `touched`; the second is kept where impacts are wanted: it pushed in the last sub-step.
constexpr u32 is_touching = 1, pushed_last = 2;

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
    const bool pushes = impulses.normal[b.contact_slots[i] % PACK] > 0;
    const bool pushed = params.substep > 0 ? (b.touched[i] & pushed_last) != 0 : b.start_impulses[i].normal > 0;
    b.touched[i] = before || pushes || current.gap <= 0 ? is_touching : 0;
    if (b.impact_speeds.empty()) continue;
    if (pushes) b.touched[i] |= pushed_last;
    const Vec3<real> of_a = point_velocity(b.previous_velocities[contact.body_a], current.arm_a);
    const Vec3<real> of_b = point_velocity(b.previous_velocities[contact.body_b], current.arm_b);
    const real speed = pushes && !pushed ? dot3(current.normal, sub3(of_b, of_a)) : real(0);
    const real fastest = params.substep > 0 ? b.impact_speeds[i] : real(0);
    b.impact_speeds[i] = speed > fastest ? speed : fastest;
  }
}

}  // namespace lockstep::reference
