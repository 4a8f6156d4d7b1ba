// Projected Gauss-Seidel with subspace minimisation (Silcowitz, Niebe, Erleben 2010, "Projected Gauss-Seidel subspace
// minimization method for interactive rigid body dynamics"). A few sweeps guess which rows are between their bounds (F)
// and which at one (B); then the guess is solved for,
//   M_FF z_F = -q_F - M_FB z_B,
// projected, and the set guessed again from what was found, a few times; what comes out is taken where it is better
// than what the sweeps left. Here a row of friction at its bound moves with its normal, z_t = +-mu z_n, so that the
// right guess gives the solution itself (the paper freezes these bounds): the column of n becomes M_.n +- mu M_.t.
#include <algorithm>

#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/lcp/splitting.hpp"

namespace lockstep::oracle::lcp {

namespace {

constexpr int sweeps = 10, subspace_steps = 4;

void project(const BoxedLcp& p, VectorXd& z) {
  for (const bool frictional : {false, true}) {  // normals first: they bound the others
    for (Index i = 0; i < z.size(); ++i) {
      if ((p.normal[std::size_t(i)] >= 0) == frictional) z[i] = std::clamp(z[i], p.low_at(i, z), p.high_at(i, z));
    }
  }
}

// Solves for the rows that a step against w leaves between their bounds; the others are put on theirs.
VectorXd minimize_on_active_set(const BoxedLcp& p, const VectorXd& scale, const VectorXd& z) {
  const Index n = p.size();
  const VectorXd w = p.m * z + p.q;
  VectorXd fixed = VectorXd::Zero(n);
  std::vector<Index> free;
  MatrixXd columns = p.m;  // of the free rows, with what is tied to them
  std::vector<double> tied(std::size_t(n), 0);
  for (Index i = 0; i < n; ++i) {
    const Index normal = p.normal[std::size_t(i)];
    const double step = z[i] - scale[i] * scale[i] * w[i], low = p.low_at(i, z), high = p.high_at(i, z);
    if (step > low && step < high) {
      free.push_back(i);
    } else if (normal >= 0) {
      tied[std::size_t(i)] = step >= high ? p.friction[i] : -p.friction[i];
      columns.col(normal) += tied[std::size_t(i)] * p.m.col(i);
    } else {
      fixed[i] = step >= high ? high : low;
    }
  }
  VectorXd x = fixed;
  if (!free.empty()) {
    const MatrixXd scaled = scale(free).asDiagonal() * MatrixXd(columns(free, free)) * scale(free).asDiagonal();
    // for the change of z, so that a singular matrix changes it least
    VectorXd start = fixed;
    for (const Index i : free) start[i] = z[i];
    for (Index i = 0; i < n; ++i) {
      if (tied[std::size_t(i)] != 0) start[i] = tied[std::size_t(i)] * start[p.normal[std::size_t(i)]];
    }
    const VectorXd defect = scale(free).cwiseProduct(VectorXd((p.m * start + p.q)(free)));
    const VectorXd change = solve_or_least_norm(scaled, -defect, 1e-12);
    for (std::size_t k = 0; k < free.size(); ++k) x[free[k]] = start[free[k]] + scale[free[k]] * change[Index(k)];
  }
  for (Index i = 0; i < n; ++i) {
    if (tied[std::size_t(i)] != 0) x[i] = tied[std::size_t(i)] * x[p.normal[std::size_t(i)]];
  }
  project(p, x);
  return x;
}

}  // namespace

SolveReport pgs_sm(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z) {
  Watch watch(problem, limits);
  if (!may_sweep(problem, watch, z)) return watch.finish(z);
  do {
    for (int k = 0; k < sweeps; ++k) gauss_seidel_sweep(problem, 1, z);
    double best = watch.measure()(z);
    VectorXd x = z;
    for (int k = 0; k < subspace_steps && best > limits.tolerance; ++k) {
      x = minimize_on_active_set(problem, watch.measure().scale(), x);
      const double found = watch.measure()(x);
      if (found >= best) continue;
      best = found;
      z = x;
    }
  } while (!watch.stop_after(z));
  return watch.finish(z);
}

SolveReport pgs_sm(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  return pgs_sm(boxed(problem), limits, z);
}

}  // namespace lockstep::oracle::lcp
