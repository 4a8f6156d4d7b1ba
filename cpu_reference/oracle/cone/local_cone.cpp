// Slip means u_n = 0 and r_t opposite to u_t: u_t = -lambda r_t with lambda > 0, so that with the normal row eliminated
//   (A + lambda) r_t = -b,   b = q_t - h q_n / w_nn,   r_n = -(q_n + h . r_t) / w_nn,   |r_t| = mu r_n.
// psi(lambda) = mu r_n / |r_t| - 1 is negative at 0 where the contact does not stick, and grows without bound since
// q_n < 0: there is a root, and any is a solution. Without coupling (h = 0, A isotropic) psi is a straight line, so
// that Newton's method finds it at once. Multiplied out, psi is the quartic of Bonnefon and Daviet, "Quartic
// formulation of Coulomb 3D frictional contact", INRIA RT-0400 (2011); enumerate() takes all of its roots.
#include "cpu_reference/oracle/cone/local_cone.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cpu_reference/oracle/cone/cone.hpp"
#include "cpu_reference/oracle/dense.hpp"

namespace lockstep::oracle {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// An eigenvalue of A that is nothing but rounding.
constexpr double nothing = 1e-13;
// What rounding of W leaves of a velocity that no impulse can change, in parts of q: joints that hold a body in all
// directions but one give W of rank one, right to 1e-14 of its largest.
constexpr double no_velocity = 1e-12;

// The real parts of the eigenvalues of a companion matrix, which is of Hessenberg form as it stands.
Eigen::Vector4d real_components(const Matrix4d& companion) {
  const double size = companion.cwiseAbs().maxCoeff();
  Eigen::RealSchur<Matrix4d> schur;
  schur.computeFromHessenberg(companion / size, Matrix4d::Identity(), false);
  const Matrix4d t = schur.matrixT() * size;
  Eigen::Vector4d real = t.diagonal();
  for (int i = 0; i < 3; ++i) {
    if (t(i + 1, i) != 0) real[i] = real[i + 1] = t(i + 1, i + 1) + 0.5 * (t(i, i) - t(i + 1, i + 1));  // a pair
  }
  return real;
}

}  // namespace

struct LocalCone::Slip {
  double q_n, size;  // |q|
  Vector2d b;        // in the eigenframe of A
};

LocalCone::LocalCone(const Matrix3d& w, double mu) : w_(w), mu_(mu) {
  mobility_ = largest_eigenvalue(0.5 * (w + w.transpose()));
  if (!(w(0, 0) > nothing * mobility_)) {  // nothing moves along the normal
    mobility_ = 0;
    return;
  }
  const Vector2d h = w.bottomLeftCorner<2, 1>();
  const Matrix2d a = w.bottomRightCorner<2, 2>() - h * h.transpose() / w(0, 0);
  const SymmetricEigen eigen = symmetric_eigen<2>(0.5 * (a + a.transpose()));
  a_ = eigen.values.cwiseMax(0);
  frame_ = eigen.vectors;
  h_ = frame_.transpose() * h;
}

LocalCone::Slip LocalCone::eliminate(const Vector3d& q) const {
  return {q[0], q.norm(), frame_.transpose() * q.tail<2>() - h_ * (q[0] / w_(0, 0))};
}

// The impulse that goes with a multiplier.
Vector3d LocalCone::impulse(const Slip& slip, double lambda) const {
  Vector2d t;
  for (int k = 0; k < 2; ++k) t[k] = slip.b[k] == 0 ? 0 : -slip.b[k] / (a_[k] + lambda);
  Vector3d r;
  r[0] = -(slip.q_n + h_.dot(t)) / w_(0, 0);
  r.tail<2>() = frame_ * t;
  return r;
}

// At rest, W r = -q; infinite where there is a direction in which the contact cannot be held.
Vector3d LocalCone::stick(const Slip& slip) const {
  Slip clamped = slip;
  for (int k = 0; k < 2; ++k) {
    if (a_[k] > nothing * mobility_) continue;
    if (std::abs(clamped.b[k]) > no_velocity * clamped.size)
      return Vector3d(0, std::numeric_limits<double>::infinity(), 0);
    clamped.b[k] = 0;
  }
  return impulse(clamped, 0);
}

Vector3d LocalCone::solve(const Vector3d& q) const {
  if (q[0] >= 0 || mobility_ <= 0) return Vector3d::Zero();
  if (mu_ == 0) return {-q[0] / w_(0, 0), 0, 0};
  const Slip slip = eliminate(q);
  const Vector3d stuck = stick(slip);
  if (stuck.tail<2>().norm() <= mu_ * stuck[0]) return stuck;

  // psi < 0 at `low`, psi > 0 at `high`
  const double b = slip.b.norm();
  double low = 0, high = b * (w_(0, 0) + mu_ * h_.norm()) / (mu_ * -q[0]);
  const double floor = 1e-3 * a_[1] + 1e-12 * high;  // keeps the bisection in ratios away from zero
  double lambda = std::max(floor, std::min(high, 0.5 * a_[0]));
  for (int iteration = 0; iteration < 200; ++iteration) {
    double t2 = 0, slope_t = 0, slope_n = 0, coupled = 0;
    for (int k = 0; k < 2; ++k) {
      if (slip.b[k] == 0) continue;
      const double t = -slip.b[k] / (a_[k] + lambda), dt = -t / (a_[k] + lambda);
      t2 += t * t;
      slope_t += t * dt;
      coupled += h_[k] * t;
      slope_n -= h_[k] * dt / w_(0, 0);
    }
    const double length = std::sqrt(t2), n = -(slip.q_n + coupled) / w_(0, 0);
    const double psi = mu_ * n / length - 1;
    (psi < 0 ? low : high) = lambda;
    if (std::abs(psi) < 4e-16 || high - low <= 1e-16 * high) break;
    const double slope = mu_ / length * (slope_n - n * slope_t / t2);
    double next = lambda - psi / slope;
    if (!(next > low && next < high)) next = std::sqrt((low + floor) * (high + floor)) - floor;
    if (next == lambda) break;
    lambda = next;
  }
  Vector3d r = impulse(slip, lambda);
  if (!r.allFinite()) return {-q[0] / w_(0, 0), 0, 0};  // there is none: the residual tells
  // what rounding left of |r_t| = mu r_n
  if (const double t = r.tail<2>().norm(); t > 0) r.tail<2>() *= mu_ * r[0] / t;
  return r[0] > 0 ? r : Vector3d(Vector3d::Zero());
}

double LocalCone::defect(const Vector3d& q, const Vector3d& r) const {
  return natural_map(r, w_ * r + q, mu_, 1 / mobility_).norm();
}

Vector3d LocalCone::enumerate(const Vector3d& q) const {
  if (q[0] >= 0 || mobility_ <= 0) return Vector3d::Zero();
  if (mu_ == 0) return {-q[0] / w_(0, 0), 0, 0};
  const Slip slip = eliminate(q);
  Vector3d best = Vector3d::Zero();
  double least = defect(q, best);
  const auto offer = [&](const Vector3d& r) {
    if (!r.allFinite()) return;
    const double d = defect(q, r);
    if (d < least) {
      least = d;
      best = r;
    }
  };
  offer(stick(slip));

  // with x = lambda / a, alpha = a_k / a: (mu N)^2 = T, where N and T are r_n and |r_t|^2 times (alpha_1 + x)(alpha_2 +
  // x) and its square, in units of b / a
  const double a = std::max(a_[1], nothing * mobility_), b = slip.b.norm();
  if (b == 0) return best;
  const Vector2d alpha = a_ / a, beta = slip.b / b;
  const std::array<double, 3> square_1 = {alpha[0] * alpha[0], 2 * alpha[0], 1},
                              square_2 = {alpha[1] * alpha[1], 2 * alpha[1], 1};
  const double q_n = slip.q_n * a / b;
  std::array<double, 3> n = {q_n * alpha[0] * alpha[1] - h_[0] * beta[0] * alpha[1] - h_[1] * beta[1] * alpha[0],
                             q_n * (alpha[0] + alpha[1]) - h_[0] * beta[0] - h_[1] * beta[1], q_n};
  for (double& c : n) c *= mu_ / w_(0, 0);
  std::array<double, 5> quartic = {};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) quartic[i + j] += n[i] * n[j];
    quartic[i] -= beta[0] * beta[0] * square_2[i] + beta[1] * beta[1] * square_1[i];
  }
  // roots of a polynomial: eigenvalues of its companion matrix
  Matrix4d companion = Matrix4d::Zero();
  for (int i = 0; i < 4; ++i) companion(i, 3) = -quartic[i] / quartic[4];
  for (int i = 0; i < 3; ++i) companion(i + 1, i) = 1;
  if (!companion.allFinite()) return solve(q);
  for (double x : real_components(companion)) {
    for (int polish = 0; polish < 3; ++polish) {
      const double value = (((quartic[4] * x + quartic[3]) * x + quartic[2]) * x + quartic[1]) * x + quartic[0];
      const double slope = ((4 * quartic[4] * x + 3 * quartic[3]) * x + 2 * quartic[2]) * x + quartic[1];
      if (slope != 0) x -= value / slope;
    }
    if (x >= 0) offer(impulse(slip, a * x));
  }
  return best;
}

// De Saxce and Feng, "The bipotential method", 1998: Uzawa's iteration on the natural map.
Vector3d LocalCone::split(const Vector3d& q, Vector3d r) const {
  if (q[0] >= 0 || mobility_ <= 0) return Vector3d::Zero();
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Vector3d change = natural_map(r, w_ * r + q, mu_, 1 / mobility_);
    r -= change;
    if (change.norm() <= 1e-12 * r.norm()) break;
  }
  return r;
}

}  // namespace lockstep::oracle
