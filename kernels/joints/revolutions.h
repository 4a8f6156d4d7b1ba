// Revolutions of the angles of joints. cpu_reference/joints/revolutions.hpp is the twin and says more.
#ifndef LOCKSTEP_JOINT_REVOLUTIONS_H
#define LOCKSTEP_JOINT_REVOLUTIONS_H

#include "joints/current_joint.h"

// Kernels of other scenes have no such angles.
static inline bool counts_revolutions(const JointInfo info) {
#if FEATURE_JOINT_ANGLES
  return COUNTS_REVOLUTIONS(info);
#else
  return false;
#endif
}

static inline void count_revolutions(const JointInfo info, global const real* joint_angles, u32 index, real dt,
                                     Motion a, Motion b, CurrentJoint* current) {
  if (!counts_revolutions(info)) return;
  current->expected = joint_angles[index] + dt * dot3(current->free_axis, sub3(vec3(b.w), vec3(a.w)));
  const real two_pi = (real)6.283185307179586;
  const real revolutions = floor((current->expected - current->coordinate) / two_pi + (real)0.5);
  current->coordinate = current->coordinate + two_pi * revolutions;
}

#endif
