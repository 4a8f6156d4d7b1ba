// A joint at the current poses of its bodies. cpu_reference/joints/current_joint.hpp is the twin and says
// more.
#ifndef LOCKSTEP_CURRENT_JOINT_H
#define LOCKSTEP_CURRENT_JOINT_H

#include "joints/angle.h"
#include "rigid_body.h"

typedef struct CurrentJoint {
  Vec3 axes[3];
  Vec3 arm_a, arm_b;
  real error[JOINT_ROWS];
  Vec3 free_axis;
  real coordinate;
  real expected;
  real lead, radius;
} CurrentJoint;

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

static inline void rotate_to_cross(CurrentJoint* current, Vec3 second) {
  const real level = sqrt(second.x * second.x + second.y * second.y);
  current->coordinate = direction_angle(second.x, second.y, level);
  if (!(level > (real)0)) return;
  const real c = second.x / level, s = second.y / level;
  const Vec3 x = current->axes[0], y = current->axes[1];
  current->axes[0] = add3(scale3(c, x), scale3(s, y));
  current->axes[1] = sub3(scale3(c, y), scale3(s, x));
}

static inline CurrentJoint current_joint(const Joint joint, u32 locked, u32 free_kind, JointSizes sizes, Vec3 x_a,
                                         Quat q_a, Vec3 x_b, Quat q_b) {
  CurrentJoint current;
  const Quat frame_a = multiply4(q_a, joint_frame(joint.frame_a));
  const Quat frame_b = multiply4(q_b, joint_frame(joint.frame_b));
  current.axes[0] = rotate3(frame_a, make3((real)1, (real)0, (real)0));
  current.axes[1] = rotate3(frame_a, make3((real)0, (real)1, (real)0));
  current.axes[2] = rotate3(frame_a, make3((real)0, (real)0, (real)1));
  current.arm_b = rotate3(q_b, vec3(joint.anchor_b));
  current.arm_a = add3(sub3(x_b, x_a), current.arm_b);
  const Vec3 d = sub3(current.arm_a, rotate3(q_a, vec3(joint.anchor_a)));
  current.coordinate = (real)0;

  Quat rotation = multiply4(make4(-frame_a.x, -frame_a.y, -frame_a.z, frame_a.w), frame_b);
  if (rotation.w < (real)0) rotation = make4(-rotation.x, -rotation.y, -rotation.z, -rotation.w);
  if ((locked >> 5 & 1u) != 0u) {
    current.error[3] = (real)2 * rotation.x;
    current.error[4] = (real)2 * rotation.y;
    current.error[5] = (real)2 * rotation.z;
  } else if (LOCKS_CROSS(locked)) {
    const Vec3 second = rotate3(rotation, make3((real)1, (real)0, (real)0));
    current.error[3] = (real)0;
    current.error[4] = -second.z;
    current.error[5] = (real)0;
    rotate_to_cross(&current, second);
  } else {
    const Vec3 axis_b = rotate3(rotation, make3((real)0, (real)0, (real)1));
    current.error[3] = -axis_b.y;
    current.error[4] = axis_b.x;
    current.error[5] = (real)0;
  }
  for (u32 i = 0u; i < 3u; ++i) current.error[i] = dot3(current.axes[i], d);

  current.free_axis = current.axes[2];
  if (free_kind == FREE_ANGLE && !LOCKS_CROSS(locked)) current.coordinate = rotation_angle(rotation.z, rotation.w);
  if (free_kind == FREE_TRAVEL) current.coordinate = current.error[2];
  if (free_kind == FREE_LENGTH) {
    current.coordinate = length3(d);
    if (current.coordinate > (real)0)
      current.free_axis = make3(d.x / current.coordinate, d.y / current.coordinate, d.z / current.coordinate);
  }
  current.lead = sizes.lead;
  if (sizes.lead != (real)0) {
    const real two_pi = (real)6.283185307179586;
    const real revolutions = floor((current.error[2] / sizes.lead - current.coordinate) / two_pi + (real)0.5);
    current.coordinate = current.coordinate + two_pi * revolutions;
    current.error[2] = current.error[2] - sizes.lead * current.coordinate;
  }
  current.radius = sizes.radius;
#if FEATURE_NON_HOLONOMIC
  if (LOCKS_SKATE(locked)) {
    current.axes[0] = rotate3(frame_b, make3((real)1, (real)0, (real)0));
    current.axes[1] = rotate3(frame_b, make3((real)0, (real)1, (real)0));
    current.axes[2] = rotate3(frame_b, make3((real)0, (real)0, (real)1));
    current.error[2] = (real)0;
  }
  if (sizes.radius > (real)0) {
    const Vec3 down = scale3(-sizes.radius, current.axes[2]);
    current.arm_a = add3(current.arm_a, down);
    current.arm_b = add3(current.arm_b, down);
    current.error[0] = (real)0;
    current.error[1] = (real)0;
  }
#endif
  return current;
}

#endif
