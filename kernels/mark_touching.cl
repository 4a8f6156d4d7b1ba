#pragma OPENCL FP_CONTRACT OFF
// Which contacts touch (cpu_reference/mark_touching.hpp).
#include "common.h"
#include "current_contact.h"
#include "types.h"

kernel void mark_touching(global const Vec4* positions, global const Vec4* orientations, global const Contact* contacts,
                          global const ContactPoint* contact_points, global const u32* contact_slots,
                          global const ImpulseBlock* impulse_blocks, global u32* touched, global const u32* counters,
                          const StepParams params) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    const Contact contact = contacts[i];
    global const ImpulseBlock* impulses = impulse_blocks + contact_slots[i] / PACK;
    const Pose pose_a = make_pose(positions[contact.body_a], orientations[contact.body_a]);
    const Pose pose_b = make_pose(positions[contact.body_b], orientations[contact.body_b]);
    const CurrentContact current = current_contact(contact_points + i, contact.normal, pose_a, pose_b);
    const bool before = params.substep > 0u && touched[i] != 0u;
    touched[i] = before || impulses->normal[contact_slots[i] % PACK] > (real)0 || current.gap <= (real)0 ? 1u : 0u;
  }
}
