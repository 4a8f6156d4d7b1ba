// Rows by the state of the contact, with x = r - rho u, all multiplied by lambda = 1 / rho:
//   open   x_n <= 0                   dr = -r, taken out of the system
//   stick  |x_t| <= mu x_n            (W dr) = -u
//   slip   d = x_t / |x_t|, P = I - d d^T, kappa = mu x_n / |x_t|
//          (W dr)_n = -u_n
//          lambda ((I - kappa P) dr_t - mu d dr_n) + kappa P (W dr)_t = -lambda Phi_t + mu d u_n
// The last is d(r_t - mu x_n x_t / |x_t|) with the row above put in for (W dr)_n. With a diagonal delta added to W, all
// are
//   a dr + b (delta dr + W dr) = c.
// Where W = H^T M^-1 H is known and has more rows than there are velocities, dr is eliminated contact by contact:
//   A = a + b delta,   (M + H A^-1 b H^T) dv = H A^-1 c,   dr = A^-1 (c - b H^T dv)
#include "cpu_reference/oracle/cone/newton_step.hpp"

#include <algorithm>
#include <cmath>

#include "cpu_reference/oracle/cone/cone.hpp"
#include "cpu_reference/oracle/cone/factor.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::uint32_t none = ~0u;

// a dr_i + b (W dr)_i = c
struct Row {
  Matrix3d a = Matrix3d::Zero(), b = Matrix3d::Identity();
  Vector3d c;
};

Row linearised(const Vector3d& r, const Vector3d& u, double mu, double lambda) {
  Row row;
  row.c = -u;
  const Vector3d x = r - u / lambda;
  const double length = x.tail<2>().norm(), radius = mu * x[0];
  if (length <= radius) return row;
  const Vector2d d = x.tail<2>() / length;
  const double kappa = radius / length;
  const Matrix2d p = Matrix2d::Identity() - d * d.transpose();
  row.a.bottomRightCorner<2, 2>() = lambda * (Matrix2d::Identity() - kappa * p);
  row.a.bottomLeftCorner<2, 1>() = -lambda * mu * d;
  row.b.bottomRightCorner<2, 2>() = kappa * p;
  row.c.tail<2>() = -lambda * (r.tail<2>() - radius * d) + mu * u[0] * d;
  return row;
}

// Adds to `direction` what the rows of the contacts that have a slot ask for.
bool solve_by_contacts(const BlockMatrix& w, const std::vector<Row>& rows, const std::vector<std::uint32_t>& slot,
                       std::uint32_t active, const VectorXd& delta, VectorXd& direction) {
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(9 * w.block.size());
  VectorXd c(3 * active);
  for (std::uint32_t i = 0; i < slot.size(); ++i) {
    if (slot[i] == none) continue;
    c.segment<3>(3 * slot[i]) = rows[i].c;
    for (std::uint32_t k = w.first[i]; k < w.first[i + 1]; ++k) {
      const std::uint32_t j = w.column[k];
      if (slot[j] == none) continue;
      Matrix3d entry = rows[i].b * w.block[k];
      if (i == j) entry += rows[i].a + rows[i].b * delta.segment<3>(3 * i).asDiagonal();
      for (int p = 0; p < 3; ++p) {
        for (int q = 0; q < 3; ++q) {
          if (entry(p, q) != 0) triplets.emplace_back(3 * slot[i] + p, 3 * slot[j] + q, entry(p, q));
        }
      }
    }
  }
  SparseMatrix j(3 * active, 3 * active);
  j.setFromTriplets(triplets.begin(), triplets.end());
  VectorXd solution;
  if (!solve_square(j, c, solution)) return false;
  for (std::uint32_t i = 0; i < slot.size(); ++i) {
    if (slot[i] != none) direction.segment<3>(3 * i) = solution.segment<3>(3 * slot[i]);
  }
  return true;
}

// The same through the velocities. Contacts stick by delta alone, so that it has a floor.
bool solve_by_velocities(const NewtonProblem& newton, const std::vector<Row>& rows,
                         const std::vector<std::uint32_t>& slot, const VectorXd& delta, VectorXd& direction) {
  const VelocityForm& velocities = *newton.problem.velocities;
  const Eigen::Index size = direction.size();
  std::vector<Eigen::Triplet<double>> triplets;
  VectorXd constant_term = VectorXd::Zero(size);
  for (std::uint32_t i = 0; i < slot.size(); ++i) {
    if (slot[i] == none) continue;
    const Vector3d d = delta.segment<3>(3 * i).cwiseMax(1e-9 * newton.mobility[i]);
    const Eigen::PartialPivLU<Matrix3d> lu(rows[i].a + rows[i].b * d.asDiagonal());
    constant_term.segment<3>(3 * i) = lu.solve(rows[i].c);
    const Matrix3d response = lu.solve(rows[i].b);
    for (int p = 0; p < 3; ++p) {
      for (int q = 0; q < 3; ++q) triplets.emplace_back(3 * i + p, 3 * i + q, response(p, q));
    }
  }
  SparseMatrix x(size, size);
  x.setFromTriplets(triplets.begin(), triplets.end());
  const SparseMatrix h_t = velocities.h.transpose(), responses = x * h_t;
  VectorXd dv;
  if (!solve_square(velocities.m + SparseMatrix(velocities.h * responses), velocities.h * constant_term, dv))
    return false;
  direction += constant_term - responses * dv;
  return direction.allFinite();
}

}  // namespace

double newton_merit(const NewtonProblem& newton, const VectorXd& r, const VectorXd& u) {
  double sum = 0;
  for (std::uint32_t i = 0; i < newton.problem.contacts(); ++i) {
    const double lambda = newton.mobility[i];
    if (lambda <= 0) continue;
    const Vector3d r_i = r.segment<3>(3 * i), x = r_i - u.segment<3>(3 * i) / lambda;
    const double n = std::max(0.0, x[0]);
    Vector3d phi(r_i[0] - n, 0, 0);
    phi.tail<2>() = r_i.tail<2>() - project_on_disc(x.tail<2>(), newton.problem.mu[i] * n);
    sum += (lambda * phi).squaredNorm();
  }
  return std::sqrt(sum);
}

bool newton_direction(const NewtonProblem& newton, double damping, const VectorXd& r, const VectorXd& u,
                      VectorXd& direction) {
  const ConeProblem& problem = newton.problem;
  const BlockMatrix& w = problem.w;
  direction = VectorXd::Zero(r.size());
  std::vector<std::uint32_t> slot(problem.contacts(), none);
  std::uint32_t active = 0;
  for (std::uint32_t i = 0; i < problem.contacts(); ++i) {
    const double lambda = newton.mobility[i];
    const bool open = lambda <= 0 || r[3 * i] - u[3 * i] / lambda <= 0;
    if (open)
      direction.segment<3>(3 * i) = -r.segment<3>(3 * i);
    else
      slot[i] = active++;
  }
  const VectorXd of_open = w.times(direction);

  std::vector<Row> rows(problem.contacts());
  VectorXd delta = newton.alpha;
  for (std::uint32_t i = 0; i < problem.contacts(); ++i) {
    if (slot[i] == none) continue;
    const double lambda = newton.mobility[i];
    rows[i] = linearised(r.segment<3>(3 * i), u.segment<3>(3 * i), problem.mu[i], lambda);
    rows[i].c -= rows[i].b * of_open.segment<3>(3 * i);
    delta.segment<3>(3 * i).array() += damping * lambda;
  }
  if (problem.velocities && problem.velocities->m.rows() < 3 * active)
    return solve_by_velocities(newton, rows, slot, delta, direction);
  return solve_by_contacts(w, rows, slot, active, delta, direction);
}

}  // namespace lockstep::oracle
