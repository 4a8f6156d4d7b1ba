// Where a joint stands at the present poses of its bodies. cpu_reference/joints/joint_now.hpp is the twin and says
// more.
#ifndef LOCKSTEP_JOINT_NOW_H
#define LOCKSTEP_JOINT_NOW_H

#include "joints/angle.h"
#include "rigid_body.h"

typedef struct JointNow {
  Vec3 axes[3];
  Vec3 arm_a, arm_b;
  real error[JOINT_ROWS];
  Vec3 free_axis;
  real coordinate;
  real lead, radius;
} JointNow;

// The pose of a body, of so many; of the null body that of the world.
static inline void joint_pose(u32 body, u32 bodies, global const Vec4* positions, global const Vec4* orientations,
                              Vec3* x, Quat* q) {
  *x = make3((real)0, (real)0, (real)0);
  *q = make4((real)0, (real)0, (real)0, (real)1);
  if (body >= bodies) return;
  *x = vec3_of(positions[body]);
  *q = quat(orientations[body]);
}

typedef struct JointSizes {
  real lead, radius;
} JointSizes;

static inline Quat joint_frame(const real* q) { return make4(q[0], q[1], q[2], q[3]); }

// Kernels of other scenes know of no screws and nothing that rolls.
static inline JointSizes joint_sizes(global const real* screw_leads, global const real* rolling_radii, u32 index) {
  JointSizes sizes = {(real)0, (real)0};
#if FEATURE_SCREWS
  sizes.lead = screw_leads[index];
#endif
#if FEATURE_NON_HOLONOMIC
  sizes.radius = rolling_radii[index];
#endif
  return sizes;
}

static inline void rotate_to_cross(JointNow* now, Vec3 second) {
  const real level = sqrt(second.x * second.x + second.y * second.y);
  now->coordinate = direction_angle(second.x, second.y, level);
  if (!(level > (real)0)) return;
  const real c = second.x / level, s = second.y / level;
  const Vec3 x = now->axes[0], y = now->axes[1];
  now->axes[0] = add3(scale3(c, x), scale3(s, y));
  now->axes[1] = sub3(scale3(c, y), scale3(s, x));
}

static inline JointNow joint_now(const Joint joint, u32 locked, u32 free_kind, JointSizes sizes, Vec3 x_a, Quat q_a,
                                 Vec3 x_b, Quat q_b) {
  JointNow now;
  const Quat frame_a = multiply4(q_a, joint_frame(joint.frame_a));
  const Quat frame_b = multiply4(q_b, joint_frame(joint.frame_b));
  now.axes[0] = rotate3(frame_a, make3((real)1, (real)0, (real)0));
  now.axes[1] = rotate3(frame_a, make3((real)0, (real)1, (real)0));
  now.axes[2] = rotate3(frame_a, make3((real)0, (real)0, (real)1));
  now.arm_b = rotate3(q_b, vec3(joint.anchor_b));
  now.arm_a = add3(sub3(x_b, x_a), now.arm_b);
  const Vec3 d = sub3(now.arm_a, rotate3(q_a, vec3(joint.anchor_a)));
  now.coordinate = (real)0;

  Quat rotation = multiply4(make4(-frame_a.x, -frame_a.y, -frame_a.z, frame_a.w), frame_b);
  if (rotation.w < (real)0) rotation = make4(-rotation.x, -rotation.y, -rotation.z, -rotation.w);
  if ((locked >> 5 & 1u) != 0u) {
    now.error[3] = (real)2 * rotation.x;
    now.error[4] = (real)2 * rotation.y;
    now.error[5] = (real)2 * rotation.z;
  } else if (LOCKS_CROSS(locked)) {
    const Vec3 second = rotate3(rotation, make3((real)1, (real)0, (real)0));
    now.error[3] = (real)0;
    now.error[4] = -second.z;
    now.error[5] = (real)0;
    rotate_to_cross(&now, second);
  } else {
    const Vec3 axis_b = rotate3(rotation, make3((real)0, (real)0, (real)1));
    now.error[3] = -axis_b.y;
    now.error[4] = axis_b.x;
    now.error[5] = (real)0;
  }
  for (u32 i = 0u; i < 3u; ++i) now.error[i] = dot3(now.axes[i], d);

  now.free_axis = now.axes[2];
  if (free_kind == FREE_ANGLE && !LOCKS_CROSS(locked)) now.coordinate = rotation_angle(rotation.z, rotation.w);
  if (free_kind == FREE_TRAVEL) now.coordinate = now.error[2];
  if (free_kind == FREE_LENGTH) {
    now.coordinate = length3(d);
    if (now.coordinate > (real)0)
      now.free_axis = make3(d.x / now.coordinate, d.y / now.coordinate, d.z / now.coordinate);
  }
  now.lead = sizes.lead;
  if (sizes.lead != (real)0) {
    const real two_pi = (real)6.283185307179586;
    const real revolutions = floor((now.error[2] / sizes.lead - now.coordinate) / two_pi + (real)0.5);
    now.coordinate = now.coordinate + two_pi * revolutions;
    now.error[2] = now.error[2] - sizes.lead * now.coordinate;
  }
  now.radius = sizes.radius;
#if FEATURE_NON_HOLONOMIC
  if (LOCKS_SKATE(locked)) {
    now.axes[0] = rotate3(frame_b, make3((real)1, (real)0, (real)0));
    now.axes[1] = rotate3(frame_b, make3((real)0, (real)1, (real)0));
    now.axes[2] = rotate3(frame_b, make3((real)0, (real)0, (real)1));
    now.error[2] = (real)0;
  }
  if (sizes.radius > (real)0) {
    const Vec3 down = scale3(-sizes.radius, now.axes[2]);
    now.arm_a = add3(now.arm_a, down);
    now.arm_b = add3(now.arm_b, down);
    now.error[0] = (real)0;
    now.error[1] = (real)0;
  }
#endif
  return now;
}

#endif
