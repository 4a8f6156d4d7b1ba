#include "host/report/joint_wrench.hpp"

#include "host/in_double.hpp"

namespace lockstep {

template <class real>
JointWrench joint_wrench(const Buffers<real>& buffers, const StepParams<real>& params, u32 index, ImpulsesOf of) {
  const JointInfo& info = buffers.joint_infos[index];
  const Joint<real>& joint = buffers.joints[index];
  // the null body stands for the world
  const auto orientation_of = [&](u32 body) {
    return body < buffers.orientations.size() ? rotation(buffers.orientations[body]) : Eigen::Quaterniond::Identity();
  };
  const auto anchor_of = [&](u32 body, const real* anchor) -> Eigen::Vector3d {
    const Eigen::Vector3d arm = orientation_of(body) * vector3(anchor);
    return body < buffers.positions.size() ? Eigen::Vector3d(vector3(buffers.positions[body]) + arm) : arm;
  };
  const JointMeasures measures = measure_joint(buffers, params, index, of);
  const Eigen::Vector3d axis = orientation_of(info.body_a) * rotation(joint.frame_a) * Eigen::Vector3d::UnitZ();
  Eigen::Vector3d force = measures.force, torque = measures.torque;
  if (info.free == FREE_ANGLE) torque += measures.drive * axis;
  if (info.free == FREE_TRAVEL) force += measures.drive * axis;
  if (info.free == FREE_LENGTH)
    force +=
        measures.drive * (anchor_of(info.body_b, joint.anchor_b) - anchor_of(info.body_a, joint.anchor_a)).normalized();
  const Eigen::Quaterniond into = (orientation_of(info.body_b) * rotation(joint.frame_b)).conjugate();
  return {into * force, into * torque};
}

template JointWrench joint_wrench(const Buffers<float>&, const StepParams<float>&, u32, ImpulsesOf);
template JointWrench joint_wrench(const Buffers<double>&, const StepParams<double>&, u32, ImpulsesOf);

}  // namespace lockstep
