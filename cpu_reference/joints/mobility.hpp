// What impulses along the rows of a joint do to the velocities of its rows. kernels/joints/mobility.h is the twin.
#pragma once

#include "cpu_reference/joints/current_joint.hpp"

namespace lockstep::reference {

/// J M^-1 J^T of the joint: row and column JOINT_ROWS are the free row's.
template <class real>
struct JointMobility {
  real k[JOINT_ROWS][JOINT_ROWS];
  real coupling[JOINT_ROWS];
  real free_mobility;
};

template <class real>
JointMobility<real> joint_mobility(const CurrentJoint<real>& current, u32 free, const Motion<real>& a,
                                   const Motion<real>& b) {
  Vec3<real> moment_a[JOINT_ROWS + 1], moment_b[JOINT_ROWS + 1];
  for (u32 i = 0; i < 3; ++i) {
    moment_a[i] = cross3(current.arm_a, current.axes[i]);
    moment_b[i] = cross3(current.arm_b, current.axes[i]);
    moment_a[i + 3] = current.axes[i];
    moment_b[i + 3] = current.axes[i];
  }
  if (current.lead != 0) {  // the thread turns what it pushes: u_z - lead w_z
    moment_a[2] = sub3(moment_a[2], scale3(current.lead, current.axes[2]));
    moment_b[2] = sub3(moment_b[2], scale3(current.lead, current.axes[2]));
  }
  const bool angular = free == FREE_ANGLE;
  moment_a[JOINT_ROWS] = angular ? current.free_axis : cross3(current.arm_a, current.free_axis);
  moment_b[JOINT_ROWS] = angular ? current.free_axis : cross3(current.arm_b, current.free_axis);

  const real inverse_mass = a.inverse_mass + b.inverse_mass;
  JointMobility<real> m;
  for (u32 j = 0; j <= JOINT_ROWS; ++j) {
    const Vec3<real> response_a = apply_inverse_inertia(a, moment_a[j]),
                     response_b = apply_inverse_inertia(b, moment_b[j]);
    for (u32 i = 0; i <= j; ++i) {
      const real share = dot3(moment_a[i], response_a) + dot3(moment_b[i], response_b);
      const real entry = i == j && (j < 3 || (j == JOINT_ROWS && !angular)) ? inverse_mass + share : share;
      if (j < JOINT_ROWS)
        m.k[j][i] = entry;
      else if (i < JOINT_ROWS)
        m.coupling[i] = entry;
      else
        m.free_mobility = entry;
    }
  }
  return m;
}

}  // namespace lockstep::reference
