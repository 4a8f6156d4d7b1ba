// Alternating direction method of multipliers (Boyd et al. 2011; for Coulomb friction: Acary, Bourrier, Viviani, and
// Tasora et al. 2021), in the metric D = sigma diag(lambda_max(W_ii)), with De Saxce's shift renewed in each iteration:
//   r <- (W + D)^-1 (D (z - y) - q - shift)          W its symmetric part; the rest, where there is one, counts to q
//   r~ <- 1.6 r - 0.6 z                              over-relaxed
//   z <- P_K(r~ + y),   y <- y + r~ - z
// D is a multiple of the identity within a contact, so that P_K is the nearest point in the metric too. At a fixed
// point -D y = W z + q + shift lies in the dual cone. sigma is moved so that r - z and D (z - z_before) shrink alike;
// each move costs a factorisation, so that they become rare. That balance is not always the fastest: a small sigma lets
// impulses that velocities hardly feel move further.
#include <algorithm>
#include <cmath>
#include <optional>

#include "cpu_reference/oracle/cone/factor.hpp"
#include "cpu_reference/oracle/cone/gradient.hpp"
#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/cone/start.hpp"
#include "cpu_reference/oracle/cone/watch.hpp"
#include "cpu_reference/oracle/joints/creep.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::VectorXd;

constexpr double relaxation = 1.6;

// sigma lambda_max in each row; of a contact that nothing moves, one
VectorXd metric(const VectorXd& mobility, double sigma) {
  VectorXd d(3 * mobility.size());
  for (Eigen::Index i = 0; i < mobility.size(); ++i)
    d.segment<3>(3 * i).setConstant(mobility[i] > 0 ? sigma * mobility[i] : 1);
  return d;
}

// `fixed_sigma`: else sigma is balanced.
SolveReport iterate(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r,
                    std::optional<double> fixed_sigma) {
  Watch watch(problem, limits);
  const VectorXd& mobility = watch.meter().mobility();
  VectorXd z = start_of(problem, r);
  if (watch.look(z, 0)) return watch.finish(r);
  double sigma = fixed_sigma.value_or(0.1);
  VectorXd d = metric(mobility, sigma);
  ShiftedCholesky cholesky(problem);
  const SparseMatrix skew = problem.w.skew();
  if (!cholesky.factorize(d)) {
    watch.stop_stalled();
    return watch.finish(r);
  }
  VectorXd u = problem.w.times(z) + problem.q, shift = de_saxce_shift(problem, u);
  VectorXd y = -(u + shift).cwiseQuotient(d);
  Creep creep(problem.mu);
  std::uint32_t next_move = 20;
  for (std::uint32_t iteration = 1;; ++iteration) {
    VectorXd pull = d.cwiseProduct(z - y) - problem.q - shift;
    if (skew.nonZeros() > 0) pull -= skew * z;
    const VectorXd x = cholesky.solve(pull);
    const VectorXd relaxed = relaxation * x + (1 - relaxation) * z, before = z;
    z = relaxed + y;
    for (std::uint32_t i = 0; i < problem.contacts(); ++i)
      z.segment<3>(3 * i) = project_on_cone(z.segment<3>(3 * i), problem.mu[i]);
    y += relaxed - z;
    u = -d.cwiseProduct(y);  // u^, whose tangential part is that of u
    shift = de_saxce_shift(problem, u);
    if (watch.is_due(iteration)) {
      if (watch.look(z, iteration)) break;
      VectorXd state(2 * z.size());
      state << z, u;
      if (const std::optional<VectorXd> further = creep.leap(state, watch.residual(), iteration)) {
        z = further->head(z.size());
        u = further->tail(z.size());
        y = -u.cwiseQuotient(d);
        shift = de_saxce_shift(problem, u);
      }
    }

    if (fixed_sigma || iteration < next_move) continue;
    // both in the units of the root of an energy, whatever the units of the problem
    const double primal_residual = std::sqrt(squared_length(mobility, x - z));
    const double moved = sigma * std::sqrt(squared_length(mobility, z - before));
    const double ratio = std::sqrt(primal_residual / std::max(moved, 1e-300));
    next_move = iteration + std::max(20u, iteration / 2);
    if (ratio > 0.4 && ratio < 2.5) continue;
    const double next = std::clamp(sigma * std::clamp(ratio, 0.1, 10.0), 1e-6, 1e3);
    const VectorXd next_d = metric(mobility, next);
    if (!cholesky.factorize(next_d)) {
      watch.stop_stalled();
      break;
    }
    y *= sigma / next;
    sigma = next;
    d = next_d;
  }
  return watch.finish(r);
}

}  // namespace

SolveReport admm(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r) {
  return iterate(problem, limits, r, {});
}

SolveReport fixed_metric_admm(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r) {
  return iterate(problem, limits, r, 0.03);
}

}  // namespace lockstep::oracle
