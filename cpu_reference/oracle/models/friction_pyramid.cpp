#include "cpu_reference/oracle/models/friction_pyramid.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "cpu_reference/oracle/dense.hpp"
#include "host/error.hpp"

namespace lockstep::oracle::models {

lcp::BoxedLcp MixedLcp::stacked() const {
  const Index m = a.size(), n = r.size();
  lcp::BoxedLcp p;
  p.m.resize(m + n, m + n);
  p.m << f, b, c, d;
  p.q.resize(m + n);
  p.q << a, r;
  p.low = VectorXd::Zero(m + n);
  p.high = VectorXd::Constant(m + n, std::numeric_limits<double>::infinity());
  p.low.tail(n) = -p.high.tail(n);
  p.normal.assign(std::size_t(m + n), -1);
  p.friction = VectorXd::Zero(m + n);
  return p;
}

Eigen::Matrix2Xd pyramid_directions(int directions) {
  if (directions < 3) {
    throw Error(Failure::input, "friction pyramid",
                "needs at least 3 directions to span a plane, not " + std::to_string(directions));
  }
  Eigen::Matrix2Xd circle(2, directions);
  for (Index j = 0; j < directions; ++j) {
    const double angle = 2 * std::numbers::pi * double(j) / directions;
    circle.col(j) << std::cos(angle), std::sin(angle);
  }
  return circle;
}

MatrixXd pyramid_couplings(const VectorXd& friction, Index dry, Index directions, Index size) {
  const Index n = friction.size(), alpha_dry = n, alpha = alpha_dry + 2 * dry;
  const Index beta_dry = alpha + n * directions, beta = beta_dry + dry;
  MatrixXd f = MatrixXd::Zero(size, size);
  for (Index k = 0; k < dry; ++k) {
    f.col(beta_dry + k).segment(alpha_dry + 2 * k, 2).setOnes();
    f.row(beta_dry + k).segment(alpha_dry + 2 * k, 2).setConstant(-1);
  }
  for (Index i = 0; i < n; ++i) {
    f.col(beta + i).segment(alpha + i * directions, directions).setOnes();
    f.row(beta + i).segment(alpha + i * directions, directions).setConstant(-1);
    f(beta + i, i) = friction[i];
  }
  return f;
}

FrictionPyramid::FrictionPyramid(const Multibody& system, int directions)
    : system_(system),
      rows_(system),
      directions_(directions),
      normals_(Index(system.contacts.size())),
      dry_(Index(system.dry_rows.size())),
      circle_(pyramid_directions(directions)) {}

MatrixXd FrictionPyramid::impulse_rows() const {
  MatrixXd rows(normals_ + 2 * dry_ + normals_ * directions_, rows_.normal.cols());
  rows.topRows(normals_) = rows_.normal;
  for (Index k = 0; k < dry_; ++k) {
    rows.row(normals_ + 2 * k) = rows_.dry.row(k);
    rows.row(normals_ + 2 * k + 1) = -rows_.dry.row(k);
  }
  for (Index i = 0; i < normals_; ++i) {
    rows.middleRows(normals_ + 2 * dry_ + i * directions_, directions_) =
        transposed_product(circle_, rows_.tangent.middleRows(2 * i, 2));
  }
  return rows;
}

MatrixXd FrictionPyramid::couplings() const {
  VectorXd friction(normals_);
  for (Index i = 0; i < normals_; ++i) friction[i] = system_.contacts[std::size_t(i)].friction;
  return pyramid_couplings(friction, dry_, directions_, size());
}

VectorXd FrictionPyramid::constants() const {
  VectorXd a = VectorXd::Zero(size());
  for (Index i = 0; i < normals_; ++i) {
    const Contact& c = system_.contacts[std::size_t(i)];
    const Eigen::Vector2d slide = tangents(c.normal).transpose() * c.slide;
    a[i] = c.bias;
    a.segment(normals_ + 2 * dry_ + i * directions_, directions_) = circle_.transpose() * slide;
  }
  for (Index k = 0; k < dry_; ++k)
    a[normals_ + 2 * dry_ + normals_ * directions_ + k] = system_.dry_rows[std::size_t(k)].limit;
  return a;
}

MixedLcp FrictionPyramid::mixed() const {
  // the velocities that constraints can change, and their inertia
  std::vector<Index> moving;
  std::vector<Eigen::Matrix3d> inertia;  // of each three of them
  for (std::size_t k = 0; k < system_.bodies.size(); ++k) {
    const Body& body = system_.bodies[k];
    const auto add = [&](Index first, const Eigen::Matrix3d& m) {
      for (Index i = 0; i < 3; ++i) moving.push_back(first + i);
      inertia.push_back(m);
    };
    if (body.inverse_mass > 0) add(6 * Index(k), Eigen::Matrix3d::Identity() / body.inverse_mass);
    if (body.inverse_inertia.isZero(0)) continue;
    const auto m = inverse_if_regular(body.inverse_inertia);
    if (!m)
      throw Error(Failure::input, "body " + std::to_string(k),
                  "turns about some axes only: Model-mLCP has no inertia for it");
    add(6 * Index(k) + 3, *m);
  }
  const Index u = Index(moving.size()), p = rows_.joint.rows();
  MatrixXd mass = MatrixXd::Zero(u, u);
  for (std::size_t k = 0; k < inertia.size(); ++k) mass.block<3, 3>(3 * Index(k), 3 * Index(k)) = inertia[k];
  VectorXd immovable = rows_.free_velocity;  // their velocities are given
  immovable(moving).setZero();

  const MatrixXd rows = impulse_rows(), along = rows(Eigen::all, moving), joint = rows_.joint(Eigen::all, moving);
  MixedLcp m;
  m.f = couplings();
  m.c = MatrixXd::Zero(u + p, size());
  m.c.topLeftCorner(u, rows.rows()) = along.transpose();
  m.b = m.c.transpose();
  m.d = MatrixXd::Zero(u + p, u + p);
  m.d.topLeftCorner(u, u) = -mass;
  m.d.topRightCorner(u, p) = joint.transpose();
  m.d.bottomLeftCorner(p, u) = joint;
  m.a = constants();
  m.a.head(rows.rows()) += rows * immovable;
  m.r.resize(u + p);
  m.r.head(u) = mass * rows_.free_velocity(moving);
  m.r.tail(p) = rows_.joint * immovable;
  for (Index i = 0; i < p; ++i) m.r[u + i] += system_.joint_rows[std::size_t(i)].bias;
  return m;
}

lcp::Lcp FrictionPyramid::reduced() const {
  const JointElimination joints(rows_, system_);
  const MatrixXd rows = impulse_rows();
  lcp::Lcp p = {couplings(), constants()};
  p.m.topLeftCorner(rows.rows(), rows.rows()) = joints.delassus(rows);
  p.q.head(rows.rows()) += joints.free_velocity(rows);
  return p;
}

Vector3d FrictionPyramid::impulse(std::size_t contact, const VectorXd& x) const {
  const Vector3d& normal = system_.contacts[contact].normal;
  const Index i = Index(contact);
  const Eigen::Vector2d friction = circle_ * x.segment(normals_ + 2 * dry_ + i * directions_, directions_);
  return x[i] * normal + tangents(normal) * friction;
}

VectorXd FrictionPyramid::dry_impulses(const VectorXd& x) const {
  VectorXd impulses(dry_);
  for (Index k = 0; k < dry_; ++k) impulses[k] = x[normals_ + 2 * k] - x[normals_ + 2 * k + 1];
  return impulses;
}

VectorXd FrictionPyramid::velocities(const VectorXd& x) const {
  const MatrixXd rows = impulse_rows();
  return JointElimination(rows_, system_).velocities(rows, x.head(rows.rows()));
}

VectorXd FrictionPyramid::joint_impulses(const VectorXd& x) const {
  const MatrixXd rows = impulse_rows();
  return JointElimination(rows_, system_).joint_impulses(rows, x.head(rows.rows()));
}

}  // namespace lockstep::oracle::models
