// Matrix splittings (survey 4.2.1): with A = M - N, and for a diagonal or triangular M,
//   z <- projection of M^-1 (N z - q)    on the box,
// A being the problem's matrix, L + D + U its parts. From A = M - N:
//   Jacobi         M = D,         N = -(L + U)
//   Gauss-Seidel   M = L + D,     N = -U
//   relaxed        M = D + g L,   N = (1 - g) D - g U,   of g (A z + q)
// (the survey prints N = L + U and N = U: the sign is lost). Row by row all are z_i <- P(z_i - g w_i / A_ii), with w
// from the start of the sweep (Jacobi) or from now (the others). The bounds of friction are those of the normal impulse
// at that moment. For a symmetric positive semidefinite A, Gauss-Seidel and 0 < g < 2 converge; Jacobi where 2 D - A is
// positive definite, which g = 1 / max_i sum_j |A_ij| / A_ii sees to (Gershgorin's circles of D^-1 A): `damped_jacobi`.
#include "cpu_reference/oracle/lcp/splitting.hpp"

#include <algorithm>

#include "cpu_reference/oracle/lcp/solvers.hpp"

namespace lockstep::oracle::lcp {

namespace {

constexpr double over_relaxation = 1.3;

template <class Sweep>
SolveReport iterate(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z, Sweep&& sweep) {
  Watch watch(problem, limits);
  if (!may_sweep(problem, watch, z)) return watch.finish(z);
  do {
    sweep(z);
  } while (!watch.stop_after(z));
  return watch.finish(z);
}

SolveReport jacobi(const BoxedLcp& problem, double relaxation, const SolveLimits& limits, VectorXd& z) {
  return iterate(problem, limits, z, [&](VectorXd& x) {
    const VectorXd before = x, w = problem.m * x + problem.q;
    for (Index i = 0; i < x.size(); ++i) {
      if (problem.m(i, i) <= 0) continue;
      const double step = before[i] - relaxation * w[i] / problem.m(i, i);
      x[i] = std::clamp(step, problem.low_at(i, before), problem.high_at(i, before));
    }
  });
}

double gershgorin(const MatrixXd& m) {
  double most = 1;
  for (Index i = 0; i < m.rows(); ++i) {
    if (m(i, i) > 0) most = std::max(most, m.row(i).cwiseAbs().sum() / m(i, i));
  }
  return most;
}

bool has_diagonal(const MatrixXd& m) {
  for (Index i = 0; i < m.rows(); ++i) {
    if (m(i, i) < 0 || (m(i, i) == 0 && (!m.row(i).isZero(0) || !m.col(i).isZero(0)))) return false;
  }
  return true;
}

}  // namespace

bool may_sweep(const BoxedLcp& problem, Watch& watch, VectorXd& z) {
  start_from(z, problem.size());
  if (watch.start(z)) return false;
  if (has_diagonal(problem.m)) return true;
  watch.end(Stop::stalled);  // out of the reach of sweeps
  return false;
}

void gauss_seidel_sweep(const BoxedLcp& problem, double relaxation, VectorXd& z) {
  const MatrixXd& m = problem.m;
  for (Index i = 0; i < z.size(); ++i) {
    if (m(i, i) <= 0) continue;
    const double step = z[i] - relaxation * (m.row(i).dot(z) + problem.q[i]) / m(i, i);
    z[i] = std::clamp(step, problem.low_at(i, z), problem.high_at(i, z));
  }
}

SolveReport projected_jacobi(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z) {
  return jacobi(problem, 1, limits, z);
}

SolveReport damped_jacobi(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z) {
  return jacobi(problem, 1 / gershgorin(problem.m), limits, z);
}

SolveReport pgs(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z) {
  return iterate(problem, limits, z, [&](VectorXd& x) { gauss_seidel_sweep(problem, 1, x); });
}

SolveReport psor(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z) {
  return iterate(problem, limits, z, [&](VectorXd& x) { gauss_seidel_sweep(problem, over_relaxation, x); });
}

SolveReport projected_jacobi(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  return projected_jacobi(boxed(problem), limits, z);
}
SolveReport damped_jacobi(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  return damped_jacobi(boxed(problem), limits, z);
}
SolveReport pgs(const Lcp& problem, const SolveLimits& limits, VectorXd& z) { return pgs(boxed(problem), limits, z); }
SolveReport psor(const Lcp& problem, const SolveLimits& limits, VectorXd& z) { return psor(boxed(problem), limits, z); }

}  // namespace lockstep::oracle::lcp
