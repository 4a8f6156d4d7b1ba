#include "cpu_reference/oracle/articulated/joint.hpp"

#include <cmath>
#include <numbers>

namespace lockstep::oracle::articulated {

namespace {

constexpr double two_pi = 2 * std::numbers::pi;

Quaterniond about_x(double angle) { return {std::cos(angle / 2), std::sin(angle / 2), 0, 0}; }
Quaterniond about_z(double angle) { return {std::cos(angle / 2), 0, 0, std::sin(angle / 2)}; }

double angle_about_z(const Quaterniond& rotation) {
  return std::remainder(2 * std::atan2(rotation.z(), rotation.w()), two_pi);
}

// The joint's part of the way from a to b: offset and rotation, in the frame in a.
struct JointTransform {
  Vector3d offset = Vector3d::Zero();
  Quaterniond rotation = Quaterniond::Identity();
};

JointTransform joint_transform(const Joint& joint, const Coordinates& c) {
  const Vector3d& x = c.value;
  switch (joint.type) {
    case JointType::hinge: return {Vector3d::Zero(), about_z(x[0])};
    case JointType::slider: return {{0, 0, x[0]}, Quaterniond::Identity()};
    case JointType::cylindrical: return {{0, 0, x[0]}, about_z(x[1])};
    case JointType::planar: return {{x[0], x[1], 0}, about_z(x[2])};
    case JointType::ball: return {Vector3d::Zero(), c.rotation};
    case JointType::universal: return {Vector3d::Zero(), about_z(x[0]) * about_x(x[1])};
    case JointType::screw: return {{0, 0, joint.lead * x[0]}, about_z(x[0])};
    case JointType::fixed:
    case JointType::distance: break;
  }
  return {};
}

}  // namespace

Quaterniond rotation_by_vector(const Vector3d& angles) {
  const double angle = angles.norm(), s = angle > 1e-8 ? std::sin(angle / 2) / angle : 0.5;
  return {std::cos(angle / 2), s * angles.x(), s * angles.y(), s * angles.z()};
}

Index freedoms(JointType type) {
  switch (type) {
    case JointType::hinge:
    case JointType::slider:
    case JointType::screw: return 1;
    case JointType::cylindrical:
    case JointType::universal: return 2;
    case JointType::planar:
    case JointType::ball: return 3;
    case JointType::fixed:
    case JointType::distance: break;
  }
  return 0;
}

JointGeometry joint_geometry(const Joint& joint, const Pose& a, const Pose& b) {
  const Quaterniond frame_a = a.q * joint.frame_a, frame_b = b.q * joint.frame_b;
  JointGeometry at;
  at.point = b.x + b.q * joint.anchor_b;
  at.offset = frame_a.conjugate() * (at.point - a.x - a.q * joint.anchor_a);
  at.rotation = frame_a.conjugate() * frame_b;
  if (at.rotation.w() < 0) at.rotation.coeffs() *= -1;
  at.second = frame_b * Vector3d::UnitX();
  const double cross = joint.type == JointType::universal ? measured(joint, at).value[0] : 0;
  at.axes = (frame_a * about_z(cross)).toRotationMatrix();
  return at;
}

Coordinates measured(const Joint& joint, const JointGeometry& at) {
  Coordinates c;
  switch (joint.type) {
    case JointType::hinge: c.value[0] = angle_about_z(at.rotation); break;
    case JointType::slider: c.value[0] = at.offset.z(); break;
    case JointType::cylindrical: c.value << at.offset.z(), angle_about_z(at.rotation), 0; break;
    case JointType::planar: c.value << at.offset.x(), at.offset.y(), angle_about_z(at.rotation); break;
    case JointType::ball: c.rotation = at.rotation; break;
    case JointType::universal: {
      const Vector3d second = at.rotation * Vector3d::UnitX();
      c.value[0] = std::atan2(second.y(), second.x());
      const Quaterniond rest = about_z(-c.value[0]) * at.rotation;
      c.value[1] = std::remainder(2 * std::atan2(rest.x(), rest.w()), two_pi);
      break;
    }
    case JointType::screw: {
      const double angle = angle_about_z(at.rotation);
      c.value[0] = angle + two_pi * std::round((at.offset.z() / joint.lead - angle) / two_pi);
      break;
    }
    case JointType::fixed:
    case JointType::distance: break;
  }
  return c;
}

Pose pose_of_b(const Joint& joint, const Pose& a, const Coordinates& coordinates) {
  const JointTransform transform = joint_transform(joint, coordinates);
  const Quaterniond frame_a = a.q * joint.frame_a;
  Pose b;
  b.q = (frame_a * transform.rotation * joint.frame_b.conjugate()).normalized();
  b.x = a.x + a.q * joint.anchor_a + frame_a * transform.offset - b.q * joint.anchor_b;
  return b;
}

Pose pose_of_a(const Joint& joint, const Pose& b, const Coordinates& coordinates) {
  const JointTransform transform = joint_transform(joint, coordinates);
  Pose a;
  a.q = (b.q * joint.frame_b * transform.rotation.conjugate() * joint.frame_a.conjugate()).normalized();
  a.x = b.x + b.q * joint.anchor_b - a.q * (joint.anchor_a + joint.frame_a * transform.offset);
  return a;
}

Coordinates moved(const Joint& joint, const Coordinates& from, const Eigen::Ref<const VectorXd>& rates, double dt) {
  Coordinates to = from;
  if (joint.type == JointType::ball)
    to.rotation = (rotation_by_vector(dt * rates) * from.rotation).normalized();
  else
    to.value.head(rates.size()) += dt * rates;
  return to;
}

Columns motion_axes(const Joint& joint, const JointGeometry& at) {
  const Vector3d x = at.axes.col(0), y = at.axes.col(1), z = at.axes.col(2), none = Vector3d::Zero();
  Columns s(6, freedoms(joint.type));
  switch (joint.type) {
    case JointType::hinge: s << spatial(none, z); break;
    case JointType::slider: s << spatial(z, none); break;
    case JointType::cylindrical: s << spatial(z, none), spatial(none, z); break;
    case JointType::planar: s << spatial(x, none), spatial(y, none), spatial(none, z); break;
    case JointType::ball: s << spatial(none, x), spatial(none, y), spatial(none, z); break;
    case JointType::universal: s << spatial(none, z), spatial(none, at.second); break;
    case JointType::screw: s << spatial(joint.lead * z, z); break;
    case JointType::fixed:
    case JointType::distance: break;
  }
  return s;
}

// With t and w the twist of b against a at the point P, and rho from P to the child's centre of mass, the child moves
// by
//   s = t + w x rho,   s' = t' + w' x rho + w x rho'
// more than with the parent (less, where the child is a). Axes are fixed in a, the second one of a cross in b; P is
// fixed in b. And the parent's part, v + w_p x r, changes by w_p x r'.
Vector6 velocity_product(const Joint& joint, const JointGeometry& at, const Pose& a, const Vector6& twist_a,
                         const Pose& b, const Vector6& twist_b, const Eigen::Ref<const VectorXd>& rates,
                         bool child_is_b) {
  const Vector3d v_a = twist_a.head<3>(), w_a = twist_a.tail<3>(), v_b = twist_b.head<3>(), w_b = twist_b.tail<3>();
  const Vector6 relative = motion_axes(joint, at) * rates;
  const Vector3d t = relative.head<3>(), w = relative.tail<3>();
  const Vector3d t_rate = w_a.cross(t);
  Vector3d w_rate = w_a.cross(w);
  if (joint.type == JointType::universal) w_rate += (w_b - w_a).cross(at.second) * rates[1];
  const Vector3d rho = (child_is_b ? b.x : a.x) - at.point;
  const Vector3d rho_rate = (child_is_b ? v_b : v_a) - (v_b + w_b.cross(at.point - b.x));
  const Vector6 own = spatial(t_rate + w_rate.cross(rho) + w.cross(rho_rate), w_rate);
  const Vector3d carried = child_is_b ? Vector3d(w_a.cross(v_b - v_a)) : Vector3d(w_b.cross(v_a - v_b));
  return spatial(carried, Vector3d::Zero()) + (child_is_b ? own : Vector6(-own));
}

LockedRows locked_rows(const Joint& joint, const JointGeometry& at) {
  LockedRows rows;
  switch (joint.type) {
    case JointType::fixed: rows.mask = 63; break;
    case JointType::hinge:
    case JointType::screw: rows.mask = 7 | 3 << 3; break;
    case JointType::slider: rows.mask = 3 | 7 << 3; break;
    case JointType::cylindrical: rows.mask = 3 | 3 << 3; break;
    case JointType::planar: rows.mask = 4 | 3 << 3; break;
    case JointType::ball: rows.mask = 7; break;
    case JointType::universal: rows.mask = 7 | 2 << 3; break;
    case JointType::distance: break;
  }
  Vector6 error = Vector6::Zero();
  error.head<3>() = at.offset;
  const Vector3d axis = at.rotation * Vector3d::UnitZ();
  if ((rows.mask >> 3) == 7) error.tail<3>() = 2 * at.rotation.vec();
  if ((rows.mask >> 3) == 3) error.segment<2>(3) << -axis.y(), axis.x();
  if (joint.type == JointType::universal) {
    error[4] = -(at.rotation * Vector3d::UnitX()).z();
    error.head<3>() = about_z(measured(joint, at).value[0]).conjugate() * at.offset;
  }
  if (joint.type == JointType::screw) error[2] -= joint.lead * measured(joint, at).value[0];
  for (int k = 0; k < 3; ++k) {
    rows.wrench.col(k).head<3>() = at.axes.col(k);
    rows.wrench.col(3 + k).tail<3>() = at.axes.col(k);
  }
  if (joint.type == JointType::screw) rows.wrench.col(2).tail<3>() = -joint.lead * at.axes.col(2);
  for (int k = 0; k < 6; ++k) {
    if ((rows.mask >> k & 1) == 0) rows.wrench.col(k).setZero(), error[k] = 0;
  }
  rows.error = error;
  return rows;
}

bool counts_revolutions(JointType type) {
  return type == JointType::hinge || type == JointType::planar || type == JointType::universal;
}

double acting_coordinate(const Joint& joint, const JointGeometry& at, double expected) {
  if (joint.type == JointType::distance) return at.offset.norm();
  const double x = measured(joint, at).value[joint.type == JointType::planar ? 2 : 0];
  return counts_revolutions(joint.type) ? x + two_pi * std::round((expected - x) / two_pi) : x;
}

Vector6 acting_axis(const Joint& joint, const JointGeometry& at) {
  const Vector3d z = at.axes.col(2), none = Vector3d::Zero();
  switch (joint.type) {
    case JointType::distance: {
      const double length = at.offset.norm();
      return spatial(length > 0 ? Vector3d(at.axes * at.offset / length) : z, none);
    }
    case JointType::slider:
    case JointType::cylindrical: return spatial(z, none);
    case JointType::hinge:
    case JointType::planar:
    case JointType::universal:
    case JointType::screw: return spatial(none, z);
    case JointType::fixed:
    case JointType::ball: break;
  }
  return Vector6::Zero();
}

}  // namespace lockstep::oracle::articulated
