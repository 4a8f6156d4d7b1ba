// All index sets (survey 4.1): a set A of unknowns that may be positive leaves a linear problem,
//   w_F - M_FA z_A = q_F,   - M_AA z_A = q_A,   w_F >= 0, z_A >= 0,
// that is, q in the cone of the columns of C = [ 1_F  -M_A ]. Where M_AA is regular it has one candidate. Where it is
// not, non-negative least squares decide (Lawson, Hanson, "Solving Least Squares Problems", 1974, chapter 23): q is in
// the cone if and only if its nearest point of the cone is q itself. So no solution is missed, whatever the matrix.
#include <algorithm>

#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/lcp/watch.hpp"

namespace lockstep::oracle::lcp {

namespace {

constexpr Index most_unknowns = 20;
constexpr double doubtful = 1e-8;  // a violation that may be rounding: nothing is shown by it

// min |C x - b| over x >= 0.
VectorXd non_negative_least_squares(const MatrixXd& c, const VectorXd& b, double zero) {
  const Index n = c.cols();
  VectorXd x = VectorXd::Zero(n);
  std::vector<Index> passive;  // what may be positive
  for (Index guard = 0; guard < 10 * n; ++guard) {
    VectorXd gradient = c.transpose() * (b - c * x);
    for (const Index i : passive) gradient[i] = 0;
    Index enter = 0;
    if (n == 0 || gradient.maxCoeff(&enter) <= zero) break;
    passive.push_back(enter);
    while (!passive.empty()) {
      const VectorXd y = solve_by_least_squares(c(Eigen::all, passive), b);
      double step = 1;
      for (std::size_t k = 0; k < passive.size(); ++k) {
        if (y[Index(k)] <= 0) step = std::min(step, x[passive[k]] / (x[passive[k]] - y[Index(k)]));
      }
      for (std::size_t k = 0; k < passive.size(); ++k) x[passive[k]] += step * (y[Index(k)] - x[passive[k]]);
      if (step == 1) break;
      std::vector<Index> kept;
      for (const Index i : passive) {
        if (x[i] > zero) {
          kept.push_back(i);
        } else {
          x[i] = 0;
        }
      }
      passive = kept;
    }
  }
  return x;
}

// z with z_i > 0 for i in A only; it need not solve the problem.
VectorXd candidate(const Lcp& p, const std::vector<Index>& a, double zero) {
  const Index n = p.size();
  VectorXd z = VectorXd::Zero(n);
  if (a.empty()) return z;
  if (const auto z_a = solve_if_regular(p.m(a, a), -p.q(a), 1e-10)) {
    z(a) = *z_a;
    return z;
  }
  MatrixXd c = MatrixXd::Identity(n, n);
  for (const Index i : a) c.col(i) = -p.m.col(i);
  const VectorXd x = non_negative_least_squares(c, p.q, zero);
  for (const Index i : a) z[i] = x[i];
  return z;
}

// By how much z breaks the laws of the problem at most.
double violation(const Lcp& p, const VectorXd& z) {
  const VectorXd w = p.m * z + p.q;
  double most = 0;
  for (Index i = 0; i < z.size(); ++i) most = std::max({most, -z[i], -w[i], std::min(z[i], w[i])});
  return most;
}

}  // namespace

SolveReport enumeration(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  SolveLimits all = limits;  // of sets to look at
  all.iterations = std::max(all.iterations, 1u << most_unknowns);
  DirectSolve solve(problem, all);
  const Index n = problem.size();
  if (n > most_unknowns) return solve.finish(VectorXd::Zero(n), Stop::limit, z);
  const double zero = std::max(solve.zero(), 1e-12);
  double least = infinity;
  for (std::uint32_t mask = 0; mask < 1u << n; ++mask) {
    if (!solve.may_pivot()) return solve.finish(VectorXd::Zero(n), Stop::limit, z);
    std::vector<Index> a;
    for (Index i = 0; i < n; ++i) {
      if (mask >> i & 1) a.push_back(i);
    }
    const VectorXd x = candidate(solve.scaled(), a, zero);
    const double broken = violation(solve.scaled(), x);
    if (broken <= zero) return solve.finish(x.cwiseMax(0), Stop::stalled, z);
    least = std::min(least, broken);
  }
  // each set has been shown to have none, by the only candidate that it has or the nearest to one
  return solve.finish(VectorXd::Zero(n), least > doubtful ? Stop::infeasible : Stop::stalled, z);
}

}  // namespace lockstep::oracle::lcp
