// Revolutions of the angles of joints. A pose tells an angle but for its revolutions: of all that it allows the angle
// is the one nearest to what is expected, the angle at the start of the sub-step (joint_angles, which prepare_joints
// writes) and on with the velocities that the bodies have. Right as long as what else moves them, as corrections and
// blows, rotates a joint by less than half a revolution in a sub-step. kernels/joints/revolutions.h is the twin.
#pragma once

#include "cpu_reference/joints/current_joint.hpp"

namespace lockstep::reference {

template <class real>
bool counts_revolutions(const Buffers<real>& b, const JointInfo& info) {
  return !b.joint_angles.empty() && COUNTS_REVOLUTIONS(info);
}

/// Before the sub-step has moved the bodies, or after. `current` is measured at their poses.
template <class real>
void count_revolutions(const Buffers<real>& b, const StepParams<real>& params, u32 index, CurrentJoint<real>& current) {
  const JointInfo& info = b.joint_infos[index];
  if (!counts_revolutions(b, info)) return;
  const Vec3<real> w = sub3(vec3(b.motions[info.body_b].w), vec3(b.motions[info.body_a].w));
  current.expected = b.joint_angles[index] + params.dt * dot3(current.free_axis, w);
  const real two_pi = real(6.283185307179586);
  const real revolutions = std::floor((current.expected - current.coordinate) / two_pi + real(0.5));
  current.coordinate = current.coordinate + two_pi * revolutions;
}

}  // namespace lockstep::reference
