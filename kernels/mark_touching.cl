#pragma OPENCL FP_CONTRACT OFF
// Which contacts touch (cpu_reference/mark_touching.hpp).
#include "common.h"
#include "current_contact.h"
#include "types.h"

#define IS_TOUCHING 1u
#define PUSHED_LAST 2u

// Velocity of the point at `arm` from the centre of mass.
static inline Vec3 touching_velocity(global const Velocity* velocity, Vec3 arm) {
  return add3(contact_load3(velocity->v), cross3(contact_load3(velocity->w), arm));
}

kernel void mark_touching(global const Vec4* positions, global const Vec4* orientations,
                          global const Velocity* previous_velocities, global const ContactImpulse* start_impulses,
                          global const Contact* contacts, global const ContactPoint* contact_points,
                          global const u32* contact_slots, global const ImpulseBlock* impulse_blocks,
                          global u32* touched, global real* impact_speeds, global const u32* counters,
                          const StepParams params) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    const Contact contact = contacts[i];
    global const ImpulseBlock* impulses = impulse_blocks + contact_slots[i] / PACK;
    const Pose pose_a = make_pose(positions[contact.body_a], orientations[contact.body_a]);
    const Pose pose_b = make_pose(positions[contact.body_b], orientations[contact.body_b]);
    const CurrentContact current = current_contact(contact_points + i, contact.normal, pose_a, pose_b);
    const bool before = params.substep > 0u && touched[i] != 0u;
    const bool pushes = impulses->normal[contact_slots[i] % PACK] > (real)0;
    const bool pushed = params.substep > 0u ? (touched[i] & PUSHED_LAST) != 0u : start_impulses[i].normal > (real)0;
    const u32 touches = before || pushes || current.gap <= (real)0 ? IS_TOUCHING : 0u;
    touched[i] = FEATURE_IMPACTS && pushes ? touches | PUSHED_LAST : touches;
    if (FEATURE_IMPACTS) {
      const Vec3 of_a = touching_velocity(previous_velocities + contact.body_a, current.arm_a);
      const Vec3 of_b = touching_velocity(previous_velocities + contact.body_b, current.arm_b);
      const real speed = pushes && !pushed ? dot3(current.normal, sub3(of_b, of_a)) : (real)0;
      const real fastest = params.substep > 0u ? impact_speeds[i] : (real)0;
      impact_speeds[i] = speed > fastest ? speed : fastest;
    }
  }
}
