// Where a contact stands at the present poses of its bodies. cpu_reference/contact_now.hpp is the twin.
#ifndef LOCKSTEP_CONTACT_NOW_H
#define LOCKSTEP_CONTACT_NOW_H

#include "shapes/manifold.h"

static inline Vec3 contact_load3(global const real* p) { return make3(p[0], p[1], p[2]); }

// How a contact stands by now.
typedef struct ContactNow {
  Vec3 normal;
  real gap;
  Vec3 arm_a, arm_b;
} ContactNow;

static inline ContactNow contact_now(global const ContactPoint* point, u32 frame, Pose pose_a, Pose pose_b) {
  const Vec3 anchor_a = rotate3(pose_a.orientation, contact_load3(point->anchor_a));
  const Vec3 anchor_b = rotate3(pose_b.orientation, contact_load3(point->anchor_b));
  const Vec3 offset_ab = sub3(pose_a.position, pose_b.position);
  const Vec3 d = sub3(add3(offset_ab, anchor_a), anchor_b);
  const real distance = length3(d);
  ContactNow now;
  now.normal = contact_load3(point->normal);
  if (frame == NORMAL_OF_A) now.normal = rotate3(pose_a.orientation, now.normal);
  if (frame == NORMAL_OF_B) now.normal = rotate3(pose_b.orientation, now.normal);
  if (frame == NORMAL_BETWEEN && distance > (real)0) now.normal = make3(d.x / distance, d.y / distance, d.z / distance);
  const real between = frame == NORMAL_BETWEEN ? distance : dot3(now.normal, d);
  now.gap = between - point->radius_a - point->radius_b;
  if (frame == NORMAL_OF_A) {
    now.arm_b = add3(anchor_b, scale3(point->radius_b, now.normal));
    now.arm_a = sub3(now.arm_b, offset_ab);
#if FEATURE_CONTINUOUS
  } else if (frame == NORMAL_OF_IMPACT) {
    now.arm_a = sub3(anchor_a, scale3(point->radius_a, now.normal));
    now.arm_b = add3(anchor_b, scale3(point->radius_b, now.normal));
#endif
  } else {
    const real depth = frame == NORMAL_OF_B ? point->radius_a : point->radius_a + (real)0.5 * now.gap;
    now.arm_a = sub3(anchor_a, scale3(depth, now.normal));
    now.arm_b = add3(now.arm_a, offset_ab);
  }
  return now;
}

#endif
