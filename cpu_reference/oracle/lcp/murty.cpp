// Murty's least-index principal pivoting (Murty 1974, "Note on a Bard-type scheme"; Cottle, Pang, Stone 1992, 4.2).
// A basis is a set A: z_A = -M_AA^-1 q_A, w_F = q_F + M_FA z_A. The least i whose value is negative changes sides.
// Finite for P matrices, whose M_AA are all regular, with up to 2^n - 1 pivots: a check on the other methods, no more.
#include "cpu_reference/oracle/lcp/principal_factor.hpp"
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/lcp/watch.hpp"

namespace lockstep::oracle::lcp {

SolveReport murty(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  constexpr double singular = 1e-11;
  DirectSolve solve(problem, limits);
  const Lcp& p = solve.scaled();
  PrincipalFactor factor(p.m, singular);
  while (true) {
    const std::vector<Index>& a = factor.set();
    VectorXd x = VectorXd::Zero(p.size());
    x(a) = factor.solve(-p.q(a));
    VectorXd basic = p.m * x + p.q;  // w_F and z_A
    basic(a) = x(a);
    Index i = 0;
    while (i < p.size() && basic[i] >= -solve.zero()) ++i;
    if (i == p.size()) return solve.finish(x.cwiseMax(0), Stop::stalled, z);
    if (!solve.may_pivot()) return solve.finish(x.cwiseMax(0), Stop::limit, z);
    const auto at = std::find(a.begin(), a.end(), i);
    if (at != a.end()) {
      factor.remove(at - a.begin());
    } else if (!factor.append(i)) {
      return solve.finish(x.cwiseMax(0), Stop::stalled, z);
    }
  }
}

}  // namespace lockstep::oracle::lcp
