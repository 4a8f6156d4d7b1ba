// A contact at the current poses of its bodies. cpu_reference/current_contact.hpp is the twin.
#ifndef LOCKSTEP_CURRENT_CONTACT_H
#define LOCKSTEP_CURRENT_CONTACT_H

#include "shapes/manifold.h"

static inline Vec3 contact_load3(global const real* p) { return make3(p[0], p[1], p[2]); }

// A contact at the current poses.
typedef struct CurrentContact {
  Vec3 normal;
  real gap;
  Vec3 arm_a, arm_b;
} CurrentContact;

static inline CurrentContact current_contact(global const ContactPoint* point, u32 frame, Pose pose_a, Pose pose_b) {
  const Vec3 anchor_a = rotate3(pose_a.orientation, contact_load3(point->anchor_a));
  const Vec3 anchor_b = rotate3(pose_b.orientation, contact_load3(point->anchor_b));
  const Vec3 offset_ab = sub3(pose_a.position, pose_b.position);
  const Vec3 d = sub3(add3(offset_ab, anchor_a), anchor_b);
  const real distance = length3(d);
  CurrentContact current;
  current.normal = contact_load3(point->normal);
  if (frame == NORMAL_OF_A) current.normal = rotate3(pose_a.orientation, current.normal);
  if (frame == NORMAL_OF_B) current.normal = rotate3(pose_b.orientation, current.normal);
  if (frame == NORMAL_BETWEEN && distance > (real)0)
    current.normal = make3(d.x / distance, d.y / distance, d.z / distance);
  const real between = frame == NORMAL_BETWEEN ? distance : dot3(current.normal, d);
  current.gap = between - point->radius_a - point->radius_b;
  if (frame == NORMAL_OF_A || frame == NORMAL_FIXED_ON_B) {
    const real depth = frame == NORMAL_OF_A ? point->radius_b : point->radius_b + (real)0.5 * current.gap;
    current.arm_b = add3(anchor_b, scale3(depth, current.normal));
    current.arm_a = sub3(current.arm_b, offset_ab);
#if FEATURE_CONTINUOUS || FEATURE_BOXES
  } else if (frame == NORMAL_OF_IMPACT) {
    current.arm_a = sub3(anchor_a, scale3(point->radius_a, current.normal));
    current.arm_b = add3(anchor_b, scale3(point->radius_b, current.normal));
#endif
  } else {
    const real depth = frame == NORMAL_OF_B ? point->radius_a : point->radius_a + (real)0.5 * current.gap;
    current.arm_a = sub3(anchor_a, scale3(depth, current.normal));
    current.arm_b = add3(current.arm_a, offset_ab);
  }
  return current;
}

#endif
