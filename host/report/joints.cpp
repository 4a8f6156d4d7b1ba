#include "host/report/joints.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "host/in_double.hpp"

namespace lockstep {

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

struct BodyFrame {
  Vector3d position = Vector3d::Zero();
  Quaterniond orientation = Quaterniond::Identity();
};

// The null body stands for the world.
template <class real>
BodyFrame body_frame(const Buffers<real>& buffers, u32 body) {
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

// Of b's side of a joint against a's, in the frame of a.
struct Offset {
  Vector3d d;  // of the anchors
  Quaterniond rotation;
};

template <class real>
Offset offset_of(const Buffers<real>& buffers, u32 index) {
  const JointInfo& info = buffers.joint_infos[index];
  const Joint<real>& joint = buffers.joints[index];
  const BodyFrame a = body_frame(buffers, info.body_a), b = body_frame(buffers, info.body_b);
  const Vector3d d =
      b.position + b.orientation * vector3(joint.anchor_b) - a.position - a.orientation * vector3(joint.anchor_a);
  const Quaterniond frame_a = a.orientation * rotation(joint.frame_a);
  return {frame_a.conjugate() * d, frame_a.conjugate() * b.orientation * rotation(joint.frame_b)};
}

constexpr double two_pi = 2 * std::numbers::pi;

// Travel of a screw for a radian; 0 of other joints.
template <class real>
double lead_of(const Buffers<real>& buffers, u32 index) {
  return buffers.screw_leads.empty() ? 0 : double(buffers.screw_leads[index]);
}

// The second arm of the cross of a universal joint, in the frame of a: the first is z.
Vector3d second_arm(const Offset& offset) { return offset.rotation * Vector3d::UnitX(); }

// Of what rolls; 0 of other joints.
template <class real>
double radius_of(const Buffers<real>& buffers, u32 index) {
  return buffers.rolling_radii.empty() ? 0 : double(buffers.rolling_radii[index]);
}

// The rows of which a pose can tell that they are violated: what rolls keeps its height alone, a skate keeps nothing.
u32 told_rows(const JointInfo& info) {
  if (info.kind == JOINT_ROLLING) return info.locked & 4u;
  return info.kind == JOINT_SKATE ? 0u : info.locked;
}

// In -pi .. pi.
double angle_of(const Offset& offset, const JointInfo& info) {
  if (LOCKS_CROSS(info.locked)) return std::atan2(second_arm(offset).y(), second_arm(offset).x());
  return std::remainder(2 * std::atan2(offset.rotation.z(), offset.rotation.w()), two_pi);
}

// Where its velocity brings an angle that counts revolutions (cpu_reference/joints/revolutions.hpp), or the travel of a
// screw its angle.
template <class real>
double expected_angle(const Buffers<real>& buffers, double dt, u32 index, const Offset& offset) {
  const JointInfo& info = buffers.joint_infos[index];
  if (const double lead = lead_of(buffers, index); lead != 0) return offset.d.z() / lead;
  if (buffers.joint_angles.empty()) return 0;
  const Quaterniond frame = body_frame(buffers, info.body_a).orientation * rotation(buffers.joints[index].frame_a);
  const Vector3d w = vector3(buffers.motions[info.body_b].w) - vector3(buffers.motions[info.body_a].w);
  return double(buffers.joint_angles[index]) + dt * (frame * Vector3d::UnitZ()).dot(w);
}

template <class real>
double coordinate(const Buffers<real>& buffers, double dt, u32 index, const Offset& offset) {
  const JointInfo& info = buffers.joint_infos[index];
  if (info.free == FREE_NOTHING) return 0;
  if (info.free == FREE_TRAVEL) return offset.d.z();
  if (info.free == FREE_LENGTH) return offset.d.norm();
  const double angle = angle_of(offset, info);
  return angle + two_pi * std::round((expected_angle(buffers, dt, index, offset) - angle) / two_pi);
}

// By how much the travel of a screw is off what its angle says.
double thread_error(const Offset& offset, const JointInfo& info, double lead) {
  return std::remainder(offset.d.z() - lead * angle_of(offset, info), two_pi * lead);
}

// The joint's axes in the world: those of its frame in a, or of its cross; of a skate those of its frame in b.
Eigen::Matrix3d axes_of(const Quaterniond& frame, const Offset& offset, const JointInfo& info) {
  if (info.kind == JOINT_SKATE) return (frame * offset.rotation).toRotationMatrix();
  const double angle = LOCKS_CROSS(info.locked) ? angle_of(offset, info) : 0;
  return (frame * Eigen::AngleAxisd(angle, Vector3d::UnitZ())).toRotationMatrix();
}

template <class real>
u32 joint_slot(const Buffers<real>& buffers, u32 joint) {
  u32 slot = 0;
  while (buffers.joint_lanes[slot / PACK].joint[slot % PACK] != joint) ++slot;
  return slot;
}

// How far a body reaches from its centre of mass: to the anchor, or its least radius of gyration; 0 of one that cannot
// move.
template <class real>
double body_size(const Buffers<real>& buffers, u32 body, const real* anchor) {
  if (body >= buffers.masses.size() || buffers.body_infos[body].kind != BODY_DYNAMIC) return 0;
  const Mass<real>& mass = buffers.masses[body];
  const double sum = vector3(mass.inverse_inertia).sum();
  return std::max(vector3(anchor).norm(), sum > 0 ? std::sqrt(3 * double(mass.inverse_mass) / sum) : 0);
}

// Of the smaller body that can move.
template <class real>
double joint_size(const Buffers<real>& buffers, u32 index) {
  const JointInfo& info = buffers.joint_infos[index];
  const Joint<real>& joint = buffers.joints[index];
  const double a = body_size(buffers, info.body_a, joint.anchor_a), b = body_size(buffers, info.body_b, joint.anchor_b);
  return a > 0 && b > 0 ? std::min(a, b) : std::max(a, b);
}

template <class real>
JointDrift drift_of(const Buffers<real>& buffers, u32 index) {
  const JointInfo& info = buffers.joint_infos[index];
  const Joint<real>& joint = buffers.joints[index];
  const Offset offset = offset_of(buffers, index);
  Vector3d d = offset.d;
  const Quaterniond& rotation = offset.rotation;
  if (const double lead = lead_of(buffers, index); lead != 0) d.z() = thread_error(offset, info, lead);

  JointDrift drift;
  drift.separation = locked_length(d, told_rows(info) & 7);
  if (info.free == FREE_LENGTH && !(joint.spring_compliance > 0))
    drift.separation = beyond(d.norm(), double(joint.low), double(joint.high));
  const bool all_angles = info.locked >> 3 == 7, axis_only = info.locked >> 3 == 3;
  if (all_angles) drift.angle = 2 * std::atan2(rotation.vec().norm(), std::abs(rotation.w()));
  const Vector3d axis = rotation * Vector3d::UnitZ();
  if (LOCKS_CROSS(info.locked)) drift.angle = std::asin(std::clamp(std::abs(second_arm(offset).z()), 0.0, 1.0));
  if (axis_only) drift.angle = std::atan2(std::hypot(axis.x(), axis.y()), axis.z());
  const bool bounded = joint.limited != 0 && !(joint.spring_compliance > 0) && info.free != FREE_ANGLE;
  const double beyond_limits =
      bounded ? beyond(coordinate(buffers, 0, index, offset), double(joint.low), double(joint.high)) : 0;
  if (const double size = joint_size(buffers, index); size > 0 && joint.spring == 0)
    drift.ratio = std::max(drift.separation, beyond_limits) / size;
  return drift;
}

}  // namespace

template <class real>
JointDrift joint_drift(const Buffers<real>& buffers) {
  JointDrift drift;
  for (u32 i = 0; i < buffers.joints.size(); ++i) {
    const JointDrift one = drift_of(buffers, i);
    drift.separation = std::max(drift.separation, one.separation);
    drift.ratio = std::max(drift.ratio, one.ratio);
    drift.angle = std::max(drift.angle, one.angle);
  }
  return drift;
}

template <class real>
JointMeasures measure_joint(const Buffers<real>& buffers, const StepParams<real>& params, u32 index, ImpulsesOf of) {
  const JointInfo& info = buffers.joint_infos[index];
  const Joint<real>& joint = buffers.joints[index];
  const BodyFrame at_a = body_frame(buffers, info.body_a), at_b = body_frame(buffers, info.body_b);
  const Motion<real>&a = buffers.motions[info.body_a], &b = buffers.motions[info.body_b];
  const Offset offset = offset_of(buffers, index);
  const Quaterniond frame = at_a.orientation * rotation(joint.frame_a);
  const Eigen::Matrix3d axes = axes_of(frame, offset, info);
  const double lead = lead_of(buffers, index);

  JointMeasures measures;
  measures.drift = drift_of(buffers, index);
  const Vector3d relative_w = vector3(b.w) - vector3(a.w);
  const Vector3d arm_b = at_b.orientation * vector3(joint.anchor_b), arm_a = at_b.position + arm_b - at_a.position;
  const Vector3d velocity = vector3(b.v) + vector3(b.w).cross(arm_b) - vector3(a.v) - vector3(a.w).cross(arm_a);
  const Vector3d axis = axes.col(2), along = frame * offset.d.normalized();
  measures.coordinate = coordinate(buffers, double(params.dt), index, offset);
  if (info.free == FREE_ANGLE) measures.speed = axis.dot(relative_w);
  if (info.free == FREE_TRAVEL) measures.speed = axis.dot(velocity);
  if (info.free == FREE_LENGTH) measures.speed = along.dot(velocity);

  const u32 slot = joint_slot(buffers, index), block = slot / PACK, lane = slot % PACK;
  if (of == ImpulsesOf::step) {
    const JointSumBlock<real>& sum = buffers.joint_sums[block];
    const double time = double(params.dt) * params.substeps;
    const auto in_lane = [lane](const real(&v)[3][PACK]) {
      return Vector3d(double(v[0][lane]), double(v[1][lane]), double(v[2][lane]));
    };
    measures.force = in_lane(sum.impulse) / time;
    measures.torque = in_lane(sum.moment) / time;
    measures.drive = double(sum.free[lane]) / time;
    return measures;
  }
  const JointImpulseBlock<real>& impulses = buffers.joint_impulses[block];
  const auto locked = [&](u32 row) { return double(impulses.locked[row][lane]) / double(params.dt); };
  measures.force = axes * Vector3d(locked(0), locked(1), locked(2));
  measures.torque = axes * Vector3d(locked(3), locked(4), locked(5) - lead * locked(2));
  measures.torque -= radius_of(buffers, index) * axis.cross(measures.force);  // what rolls is held where it touches
  measures.drive = (double(impulses.free[lane]) + double(impulses.impedance[lane])) / double(params.dt);
  return measures;
}

// The law of a spring is compiled to rate = k / (theta h k + c) and compliance = 1 / (h (theta h k + c)).
template <class real>
double spring_energy(const Buffers<real>& buffers, const StepParams<real>& params, u32 index) {
  const Joint<real>& joint = buffers.joints[index];
  const auto energy = [&](real rate, real compliance, real rest) -> double {
    if (compliance == 0) return 0;
    const double stretch = coordinate(buffers, double(params.dt), index, offset_of(buffers, index)) - double(rest);
    return 0.5 * double(rate) / (double(compliance) * double(params.dt)) * stretch * stretch;
  };
  const bool keeps = !(joint.motor_force < 0);  // not of bounded force
  return (keeps ? energy(joint.rate, joint.spring_compliance, joint.low) : 0) +
         energy(joint.side_rate, joint.side_compliance, joint.side_rest);
}

template <class real>
double coupling_energy(const Buffers<real>& buffers, const StepParams<real>& params, u32 index) {
  const Coupling<real>& coupling = buffers.couplings[index];
  if (coupling.compliance == 0) return 0;
  const CouplingInfo& info = buffers.coupling_infos[index];
  double stretch = -double(coupling.rest);
  for (u32 k = info.first; k < info.first + info.count; ++k) {
    const u32 joint = buffers.coupled_joints[k].joint;
    const double x = coordinate(buffers, double(params.dt), joint, offset_of(buffers, joint));
    stretch += double(buffers.coupling_ratios[k]) * x;
  }
  return 0.5 * double(coupling.rate) / (double(coupling.compliance) * double(params.dt)) * stretch * stretch;
}

template <class real>
double armature_energy(const Buffers<real>& buffers, const StepParams<real>& params, u32 index) {
  const double armature = double(buffers.joints[index].armature);
  if (armature == 0) return 0;
  const double speed = measure_joint(buffers, params, index, ImpulsesOf::last_substep).speed;
  return 0.5 * armature * speed * speed;
}

template <class real>
bool joints_conserve_energy(const Buffers<real>& buffers, const StepParams<real>& params) {
  const double theta = params.theta > 0 ? double(params.theta) : 1;  // explicit Euler takes springs implicitly too
  const double undamped = 1 / (theta * double(params.dt));           // the rate of a spring without a damper
  const double rounding = 4 * double(std::numeric_limits<real>::epsilon());
  const auto damped = [&](real rate, real compliance) {
    return compliance > 0 && double(rate) < (1 - rounding) * undamped;
  };
  const auto keeps = [&](const Coupling<real>& coupling) {
    return !damped(coupling.rate, coupling.compliance) && (coupling.limited == 0 || coupling.low == coupling.high);
  };
  if (!std::ranges::all_of(buffers.couplings, keeps)) return false;
  return std::ranges::all_of(buffers.joints, [&](const Joint<real>& joint) {
    const bool loses = damped(joint.rate, joint.spring_compliance) || damped(joint.side_rate, joint.side_compliance);
    const bool equal = joint.low == joint.high;
    return joint.motor_force == 0 && joint.spring == 0 && !loses && (joint.limited == 0 || equal);
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

#define INSTANTIATE(real)                                                                               \
  template JointMeasures measure_joint(const Buffers<real>&, const StepParams<real>&, u32, ImpulsesOf); \
  template JointDrift joint_drift(const Buffers<real>&);                                                \
  template double spring_energy(const Buffers<real>&, const StepParams<real>&, u32);                    \
  template double coupling_energy(const Buffers<real>&, const StepParams<real>&, u32);                  \
  template double armature_energy(const Buffers<real>&, const StepParams<real>&, u32);                  \
  template bool joints_conserve_energy(const Buffers<real>&, const StepParams<real>&);                  \
  template bool joints_conserve_momentum(const Buffers<real>&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
