#include "host/report/least_norm.hpp"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "host/report/contact_system.hpp"

namespace lockstep {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Block = Eigen::Matrix<double, 3, 6>;

constexpr double accuracy = 1e-9;      // of the sums, in parts of the largest impulse
constexpr double wanted = 1e-13;       // the same, where rounding lets it be met
constexpr double least_slope = 1e-12;  // of a told impulse, where there is no friction: less is rounding
constexpr double least_axis = 1e-3;    // of what of an axis of anisotropy must be in the tangent plane
constexpr int most_proximal_steps = 14, most_newton_steps = 60;

struct Projection {
  Vector3d x;
  Matrix3d derivative;  // an element of the generalised Jacobian; symmetric, positive semidefinite
};

// The nearest point x to r of the cone (x_1 / mu_1)^2 + (x_2 / mu_2)^2 <= x_n^2, x_n >= 0; there is no x_k where mu_k
// is 0. On its boundary x_n = s and x_k = mu_k^2 r_k s / d_k with d_k = s - r_n + mu_k^2 s, where s is the root of
// sum (mu_k r_k / d_k)^2 = 1 (the conditions of Karush, Kuhn and Tucker): by Newton's method on the inverse root of
// that sum, which is linear where the cone is round.
Projection project(const Vector2d& mu, const Vector3d& r) {
  const double n = r[0];
  const Vector2d c = Vector2d::Ones() + mu.cwiseAbs2(), a = mu.cwiseProduct(r.tail<2>().cwiseAbs());
  Vector3d has(1, 0, 0);
  double slope_of_r = 0;
  for (int k = 0; k < 2; ++k) {
    if (mu[k] == 0) continue;
    has[k + 1] = 1;
    slope_of_r = std::hypot(slope_of_r, r[k + 1] / mu[k]);
  }
  if (slope_of_r <= n) return {has.cwiseProduct(r), has.asDiagonal()};
  if (a.norm() <= -n) return {Vector3d::Zero(), Matrix3d::Zero()};

  double s = std::max(n, (a.norm() + n) / c.maxCoeff());  // below the root
  for (int i = 0; i < 100; ++i) {
    double sum = 0, derivative = 0;
    for (int k = 0; k < 2; ++k) {
      if (a[k] == 0) continue;
      const double d = s - n + mu[k] * mu[k] * s, square = a[k] * a[k] / (d * d);
      sum += square;
      derivative -= 2 * c[k] * square / d;
    }
    const double step = 2 * sum * (1 - std::sqrt(sum)) / derivative;
    s += step;
    if (std::abs(step) <= 1e-16 * s) break;
  }
  // the gradient of the cone's function at x, and the diagonal of A, the Hessian of the Lagrangian
  Vector3d x(s, 0, 0), outward(-s, 0, 0), diagonal(n / s, 0, 0);
  for (int k = 0; k < 2; ++k) {
    if (mu[k] == 0) continue;
    const double squared = mu[k] * mu[k];
    x[k + 1] = squared * r[k + 1] * s / (s - n + squared * s);
    outward[k + 1] = x[k + 1] / squared;
    diagonal[k + 1] = 1 + (1 - n / s) / squared;
  }
  // the inverse of A in the plane that touches the cone: 1 along x, bent across it
  const Vector3d along = x.normalized();
  Matrix3d derivative = along * along.transpose();
  if (mu.minCoeff() > 0) {
    const Vector3d across = outward.cross(x).normalized();
    derivative += across * across.transpose() / across.dot(diagonal.cwiseProduct(across));
  }
  return {x, derivative};
}

// A set of bodies that contacts join, and those contacts; lengths and impulses in parts of the largest.
class Problem {
 public:
  Problem(std::span<const SharedContact> contacts, const std::vector<u32>& members);
  /// False where the sums are not met.
  bool solve();
  Vector3d impulse(std::size_t i) const { return scale_ * (rows_[i].axes * rows_[i].projection.x); }

 private:
  struct Row {
    Matrix3d axes;       // columns: normal and tangents
    Vector2d mu;         // along the tangents
    int body[2];         // of the unknowns; -1: none
    Block from_body[2];  // velocity of the contact, in its axes, of those of a body
    Vector3d told;
    Projection projection;
  };
  // Projects all rows for these velocities. Returns the dual function without the proximal term.
  double evaluate(const VectorXd& velocities);
  VectorXd sums(bool told) const;
  bool minimize(VectorXd& velocities, const VectorXd& center, double sigma, double tolerance);
  VectorXd newton_step(const VectorXd& gradient, double sigma);

  std::vector<Row> rows_;
  Eigen::Index unknowns_ = 0;
  double scale_ = 0;
  VectorXd wanted_sums_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  bool is_analyzed_ = false;
};

// Normal, tangent along the axis of anisotropy, tangent across it: orthonormal, whatever float made of the normal.
Matrix3d axes_of(const SharedContact& contact) {
  const Vector3d n = contact.normal.normalized();
  const Vector3d in_plane = contact.axis - n.dot(contact.axis) * n;
  const Vector3d along = in_plane.norm() < least_axis ? n.unitOrthogonal() : in_plane.normalized();
  Matrix3d axes;
  axes << n, along, n.cross(along);
  return axes;
}

// Of the cone, as wide as the told impulse, in its axes, where that is outside of it.
Vector2d friction_of(const SharedContact& contact, const Vector3d& told) {
  const bool is_round = contact.normal.cross(contact.axis).norm() < least_axis;
  Vector2d mu(contact.along, is_round ? contact.along : contact.across);
  if (told[0] <= 0) return mu;
  double beyond = 0;
  for (int k = 0; k < 2; ++k) {
    const double slope = std::abs(told[k + 1]) / told[0];
    if (mu[k] == 0 && slope > least_slope) mu[k] = slope;
    if (mu[k] > 0) beyond = std::hypot(beyond, slope / mu[k]);
  }
  return std::max(beyond, 1.0) * mu;
}

Problem::Problem(std::span<const SharedContact> contacts, const std::vector<u32>& members) {
  struct Body {
    int index;
    Vector3d sum = Vector3d::Zero();
    double count = 0;
    Vector3d center() const { return sum / count; }
  };
  std::map<u32, Body> bodies;
  double length = 0;
  for (const u32 i : members) {
    scale_ = std::max(scale_, contacts[i].impulse.norm());
    for (const u32 id : {contacts[i].body_a, contacts[i].body_b}) {
      if (id == NONE) continue;
      Body& body = bodies.try_emplace(id, Body{static_cast<int>(bodies.size())}).first->second;
      body.sum += contacts[i].point;
      ++body.count;
    }
  }
  for (const u32 i : members)
    for (const u32 id : {contacts[i].body_a, contacts[i].body_b})
      if (id != NONE) length = std::max(length, (contacts[i].point - bodies.at(id).center()).norm());
  if (length == 0) length = 1;
  unknowns_ = 6 * static_cast<Eigen::Index>(bodies.size());
  for (const u32 i : members) {
    Row row;
    row.axes = axes_of(contacts[i]);
    row.told = row.axes.transpose() * contacts[i].impulse / scale_;
    row.mu = friction_of(contacts[i], row.told);
    for (int side = 0; side < 2; ++side) {
      const u32 id = side == 0 ? contacts[i].body_a : contacts[i].body_b;
      row.body[side] = id == NONE ? -1 : bodies.at(id).index;
      if (id == NONE) continue;
      Block block;
      block << Matrix3d::Identity(), -cross_matrix((contacts[i].point - bodies.at(id).center()) / length);
      row.from_body[side] = (side == 0 ? 1 : -1) * row.axes.transpose() * block;
    }
    rows_.push_back(row);
  }
  wanted_sums_ = sums(true);
}

VectorXd Problem::sums(bool told) const {
  VectorXd sums = VectorXd::Zero(unknowns_);
  for (const Row& row : rows_)
    for (int side = 0; side < 2; ++side)
      if (row.body[side] >= 0)
        sums.segment<6>(6 * row.body[side]) += row.from_body[side].transpose() * (told ? row.told : row.projection.x);
  return sums;
}

double Problem::evaluate(const VectorXd& velocities) {
  double squares = 0;
  for (Row& row : rows_) {
    Vector3d u = Vector3d::Zero();
    for (int side = 0; side < 2; ++side)
      if (row.body[side] >= 0) u += row.from_body[side] * velocities.segment<6>(6 * row.body[side]);
    row.projection = project(row.mu, u);
    squares += row.projection.x.squaredNorm();
  }
  return 0.5 * squares - velocities.dot(wanted_sums_);
}

// (G J G^T + 1/sigma) step = -gradient.
VectorXd Problem::newton_step(const VectorXd& gradient, double sigma) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int at_row, int at_column, const Eigen::Matrix<double, 6, 6>& block) {
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        if (6 * at_row + i >= 6 * at_column + j) entries.emplace_back(6 * at_row + i, 6 * at_column + j, block(i, j));
  };
  for (int body = 0; body < unknowns_ / 6; ++body) add(body, body, Eigen::Matrix<double, 6, 6>::Identity() / sigma);
  for (const Row& row : rows_)
    for (int side = 0; side < 2; ++side)
      for (int other = 0; other < 2; ++other)
        if (row.body[side] >= 0 && row.body[other] >= 0 && row.body[side] >= row.body[other])
          add(row.body[side], row.body[other],
              row.from_body[side].transpose() * row.projection.derivative * row.from_body[other]);
  Eigen::SparseMatrix<double> matrix(unknowns_, unknowns_);
  matrix.setFromTriplets(entries.begin(), entries.end());
  if (!is_analyzed_) factor_.analyzePattern(matrix);
  is_analyzed_ = true;
  factor_.factorize(matrix);
  return -factor_.solve(gradient);
}

// Of the dual function with |l - center|^2 / (2 sigma), until its gradient is within the tolerance. False where
// rounding ends it before.
bool Problem::minimize(VectorXd& velocities, const VectorXd& center, double sigma, double tolerance) {
  const auto value_at = [&](const VectorXd& at) { return evaluate(at) + (at - center).squaredNorm() / (2 * sigma); };
  double value = value_at(velocities);
  for (int i = 0; i < most_newton_steps; ++i) {
    const VectorXd gradient = sums(false) - wanted_sums_ + (velocities - center) / sigma;
    const double size = gradient.lpNorm<Eigen::Infinity>();
    if (size <= tolerance) return true;
    const VectorXd step = newton_step(gradient, sigma);
    const double slope = gradient.dot(step);
    double share = 1;
    for (;; share /= 2) {
      const VectorXd next = velocities + share * step;
      const double there = value_at(next);
      const double smaller = (sums(false) - wanted_sums_ + (next - center) / sigma).lpNorm<Eigen::Infinity>();
      if (there <= value + 1e-4 * share * slope || smaller < 0.5 * size) {
        velocities = next;
        value = there;
        break;
      }
      if (share < 1e-10) return false;
    }
  }
  return false;
}

bool Problem::solve() {
  for (Row& row : rows_) row.projection.derivative = Matrix3d::Identity();  // as though there were no cones
  double sigma = 1e4, missed = 1;
  VectorXd velocities = newton_step(-wanted_sums_, sigma);
  for (int i = 0; i < most_proximal_steps && missed > wanted; ++i, sigma *= 10) {
    const VectorXd center = velocities;
    const bool is_there = minimize(velocities, center, sigma, std::max(0.1 * wanted, 1e-3 * missed));
    evaluate(velocities);
    missed = (sums(false) - wanted_sums_).lpNorm<Eigen::Infinity>();
    if (!is_there && missed <= accuracy) break;
  }
  return missed <= accuracy;
}

}  // namespace

std::vector<Vector3d> least_norm_impulses(std::span<const SharedContact> contacts) {
  std::vector<Vector3d> impulses;
  std::map<u32, u32> parent;
  const auto root_of = [&](u32 body) {
    while (parent.try_emplace(body, body).first->second != body) body = parent[body] = parent[parent[body]];
    return body;
  };
  for (const SharedContact& contact : contacts) {
    impulses.push_back(contact.impulse);
    if (contact.body_a != NONE && contact.body_b != NONE) parent[root_of(contact.body_a)] = root_of(contact.body_b);
  }
  std::map<u32, std::vector<u32>> sets;
  for (u32 i = 0; i < contacts.size(); ++i) {
    const u32 body = contacts[i].body_a == NONE ? contacts[i].body_b : contacts[i].body_a;
    if (body != NONE) sets[root_of(body)].push_back(i);
  }
  for (const auto& [body, members] : sets) {
    const bool any = std::ranges::any_of(members, [&](u32 i) { return contacts[i].impulse != Vector3d::Zero(); });
    if (!any) continue;
    Problem problem(contacts, members);
    if (!problem.solve()) continue;
    for (std::size_t k = 0; k < members.size(); ++k) impulses[members[k]] = problem.impulse(k);
  }
  return impulses;
}

}  // namespace lockstep
