// What impulses along the rows of a joint do to the velocities of its rows. cpu_reference/joints/mobility.hpp is the
// twin.
#ifndef LOCKSTEP_JOINT_MOBILITY_H
#define LOCKSTEP_JOINT_MOBILITY_H

#include "joints/current_joint.h"

// J M^-1 J^T of the joint; `coupling` and `free_mobility` are the column of its free row.
static inline void joint_mobility(const CurrentJoint* current, bool angular, Motion a, Motion b,
                                  real k[JOINT_ROWS][JOINT_ROWS], real coupling[JOINT_ROWS], real* free_mobility) {
  Vec3 moment_a[JOINT_ROWS + 1u], moment_b[JOINT_ROWS + 1u];
  for (u32 i = 0u; i < 3u; ++i) {
    moment_a[i] = cross3(current->arm_a, current->axes[i]);
    moment_b[i] = cross3(current->arm_b, current->axes[i]);
    moment_a[i + 3u] = current->axes[i];
    moment_b[i + 3u] = current->axes[i];
  }
  if (current->lead != (real)0) {
    moment_a[2] = sub3(moment_a[2], scale3(current->lead, current->axes[2]));
    moment_b[2] = sub3(moment_b[2], scale3(current->lead, current->axes[2]));
  }
  moment_a[JOINT_ROWS] = angular ? current->free_axis : cross3(current->arm_a, current->free_axis);
  moment_b[JOINT_ROWS] = angular ? current->free_axis : cross3(current->arm_b, current->free_axis);

  const real inverse_mass = a.inverse_mass + b.inverse_mass;
  for (u32 j = 0u; j <= JOINT_ROWS; ++j) {
    const Vec3 response_a = apply_inverse_inertia(a, moment_a[j]), response_b = apply_inverse_inertia(b, moment_b[j]);
    for (u32 i = 0u; i <= j; ++i) {
      const real share = dot3(moment_a[i], response_a) + dot3(moment_b[i], response_b);
      const real entry = i == j && (j < 3u || (j == JOINT_ROWS && !angular)) ? inverse_mass + share : share;
      if (j < JOINT_ROWS)
        k[j][i] = entry;
      else if (i < JOINT_ROWS)
        coupling[i] = entry;
      else
        *free_mobility = entry;
    }
  }
}

#endif
