// What a joint does to the second of its bodies.
#pragma once

#include <Eigen/Core>

#include "host/report/joints.hpp"

namespace lockstep {

/// In the joint's frame as b carries it: z along its axis, x and y those that exact::rotation_from_z_to() gives at load
/// (docs/reference/forces.md), of a universal joint z along its first arm and x along its second.
struct JointWrench {
  Eigen::Vector3d force, torque;  // on b at its anchor and about it, N and N m
};

/// All that measure_joint() tells: its locked rows, and what drives its free coordinate.
template <class real>
JointWrench joint_wrench(const Buffers<real>& buffers, const StepParams<real>& params, u32 joint, ImpulsesOf of);

}  // namespace lockstep
