#include "host/report/joints.hpp"

#include <algorithm>
#include <cmath>

#include "host/in_double.hpp"

namespace lockstep {

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

struct Stand {
  Vector3d position = Vector3d::Zero();
  Quaterniond orientation = Quaterniond::Identity();
};

// The null body stands for the world.
template <class real>
Stand stand_of(const Buffers<real>& buffers, u32 body) {
  if (body >= buffers.positions.size()) return {};
  return {vector3(buffers.positions[body]), rotation(buffers.orientations[body])};
}

double beyond(double x, double low, double high) { return std::max({low - x, x - high, 0.0}); }

// Three rows of which bits tell which are locked.
double locked_length(Vector3d rows, u32 locked) {
  for (int i = 0; i < 3; ++i) {
    if ((locked >> i & 1) == 0) rows[i] = 0;
  }
  return rows.norm();
}

template <class real>
JointDrift drift_of(const Buffers<real>& buffers, u32 index) {
  const JointInfo& info = buffers.joint_infos[index];
  const Joint<real>& joint = buffers.joints[index];
  const Stand a = stand_of(buffers, info.body_a), b = stand_of(buffers, info.body_b);
  const Vector3d d =
      b.position + b.orientation * vector3(joint.anchor_b) - a.position - a.orientation * vector3(joint.anchor_a);
  const Quaterniond frame_a = a.orientation * rotation(joint.frame_a);
  const Quaterniond turn = frame_a.conjugate() * b.orientation * rotation(joint.frame_b);

  JointDrift drift;
  drift.separation = locked_length(frame_a.conjugate() * d, info.locked & 7);
  if (info.free == FREE_LENGTH && !(joint.yield > 0))
    drift.separation = beyond(d.norm(), double(joint.low), double(joint.high));
  const bool all_angles = info.locked >> 3 == 7, axis_only = info.locked >> 3 == 3;
  if (all_angles) drift.angle = 2 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
  const Vector3d axis = turn * Vector3d::UnitZ();
  if (axis_only) drift.angle = std::atan2(std::hypot(axis.x(), axis.y()), axis.z());
  return drift;
}

}  // namespace

template <class real>
JointDrift joint_drift(const Buffers<real>& buffers) {
  JointDrift drift;
  for (u32 i = 0; i < buffers.joints.size(); ++i) {
    const JointDrift one = drift_of(buffers, i);
    drift.separation = std::max(drift.separation, one.separation);
    drift.angle = std::max(drift.angle, one.angle);
  }
  return drift;
}

template <class real>
bool joints_conserve_energy(const Buffers<real>& buffers) {
  return std::ranges::all_of(buffers.joints, [](const Joint<real>& joint) {
    const bool equal = joint.low == joint.high;
    return joint.motor_force == 0 && joint.spring == 0 && joint.yield == 0 && (joint.limited == 0 || equal);
  });
}

template <class real>
bool joints_conserve_momentum(const Buffers<real>& buffers) {
  const auto is_dynamic = [&](u32 body) {
    return body < buffers.body_infos.size() && buffers.body_infos[body].kind == BODY_DYNAMIC;
  };
  return std::ranges::all_of(buffers.joint_infos, [&](const JointInfo& joint) {
    return is_dynamic(joint.body_a) && is_dynamic(joint.body_b);
  });
}

#define INSTANTIATE(real)                                     \
  template JointDrift joint_drift(const Buffers<real>&);      \
  template bool joints_conserve_energy(const Buffers<real>&); \
  template bool joints_conserve_momentum(const Buffers<real>&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
