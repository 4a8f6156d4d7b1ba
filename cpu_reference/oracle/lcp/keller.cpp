// Keller's principal pivoting (Keller 1973, "The general quadratic optimization problem"; as in Lacoursiere 2003,
// "Splitting methods for dry frictional contact problems in rigid multibody systems"). z >= 0 and w_A = 0 are kept
// while the rest of w may have any sign: the row r with the most negative w_r drives z_r up,
//   z_A' = -M_AA^-1 M_Ar,   w_r' = M_rr + M_rA z_A',
// until w_r = 0, and r joins A, or some z_i = 0, and i leaves A while r drives on. For a symmetric positive
// semidefinite M every drive lowers 1/2 z.Mz + q.z, so that no set A comes back, degenerate or not; and M_AA stays
// positive definite: a row joins with w_r' > 0 only. Where nothing blocks a drive the objective has no bound, and w >=
// 0 no solution, which is looked at (certificate.hpp).
#include "cpu_reference/oracle/lcp/certificate.hpp"
#include "cpu_reference/oracle/lcp/principal_factor.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/lcp/watch.hpp"

namespace lockstep::oracle::lcp {

namespace {

constexpr double still = 1e-11;  // a rate w_r' that counts as 0

// Drives row r until it has joined A. Says why it could not, `solved` if it could.
Stop drive(DirectSolve& solve, PrincipalFactor& factor, Index r, double w_r, VectorXd& x) {
  const MatrixXd& m = solve.scaled().m;
  while (solve.may_pivot()) {
    const std::vector<Index> a = factor.set();
    const VectorXd rate = factor.solve(-m(a, r));
    const double rate_w = m(r, r) + m(r, a).dot(rate);
    double step = rate_w > still ? -w_r / rate_w : infinity;
    Index blocking = -1;
    for (Index k = 0; k < Index(a.size()); ++k) {
      const double x_k = x[a[std::size_t(k)]];
      if (rate[k] < -still && -x_k / rate[k] < step) {
        step = -x_k / rate[k];
        blocking = k;
      }
    }
    if (step == infinity) {
      VectorXd ray = VectorXd::Zero(m.rows());
      ray(a) = rate;
      ray[r] = 1;
      return proves_infeasible(solve.scaled(), ray) ? Stop::infeasible : Stop::stalled;
    }
    x(a) += step * rate;
    x[r] += step;
    w_r += step * rate_w;
    if (blocking < 0) return factor.append(r) ? Stop::solved : Stop::stalled;
    x[a[std::size_t(blocking)]] = 0;
    factor.remove(blocking);
  }
  return Stop::limit;
}

}  // namespace

SolveReport keller(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  DirectSolve solve(problem, limits);
  const Lcp& p = solve.scaled();
  PrincipalFactor factor(p.m, still);
  VectorXd x = VectorXd::Zero(p.size());
  while (p.size() > 0) {
    const VectorXd w = p.m * x + p.q;
    Index r = 0;
    double worst = 0;
    for (Index i = 0; i < p.size(); ++i) {
      const bool in_set = x[i] > 0;
      if (!in_set && w[i] < worst) {
        worst = w[i];
        r = i;
      }
    }
    if (worst >= -solve.zero()) break;
    const Stop why = drive(solve, factor, r, worst, x);
    if (why != Stop::solved) return solve.finish(x, why, z);
    const std::vector<Index>& a = factor.set();
    x(a) = factor.solve(-p.q(a)).cwiseMax(0);  // rounding does not add up
  }
  return solve.finish(x, Stop::stalled, z);
}

}  // namespace lockstep::oracle::lcp
