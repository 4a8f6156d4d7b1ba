// Spatial vectors (Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 2), in the world's axes and about the
// centre of mass of the body that they belong to, so that the inertia of a body is diag(m, I). Linear parts stand
// first:
//   twist   (v, w)   velocity of the point, m/s, and angular velocity, rad/s; or their changes
//   wrench  (f, n)   force and moment about the point, N and N m; or impulses, N s and N m s
// Between two points, r from the first to the second (X = [1 -[r]; 0 1]):
//   twist at the second = X twist at the first        v + w x r
//   wrench about the first = X^T wrench about the second        n + r x f
#pragma once

#include <Eigen/Geometry>

namespace lockstep::oracle::articulated {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
/// Up to six spatial vectors.
using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;

inline Vector6 spatial(const Vector3d& linear, const Vector3d& angular) {
  Vector6 s;
  s << linear, angular;
  return s;
}

/// [a] with [a] b = a x b.
inline Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// X of the file's head.
inline Matrix6 shift(const Vector3d& r) {
  Matrix6 x = Matrix6::Identity();
  x.topRightCorner<3, 3>() = -cross_matrix(r);
  return x;
}

/// X twist, for a point that is r away from the one of the twist.
inline Vector6 twist_at(const Vector6& twist, const Vector3d& r) {
  return spatial(twist.head<3>() + twist.tail<3>().cross(r), twist.tail<3>());
}

/// X^T wrench, for a point from which the one of the wrench is r away.
inline Vector6 wrench_from(const Vector6& wrench, const Vector3d& r) {
  return spatial(wrench.head<3>(), wrench.tail<3>() + r.cross(wrench.head<3>()));
}

}  // namespace lockstep::oracle::articulated
