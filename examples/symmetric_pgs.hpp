// A solver of one's own, step by step in docs/tutorials/add_a_solver.md: projected Gauss-Seidel that sweeps over the
// rows forwards and then backwards, so that no row is always the last (survey 4.2.1; symmetric successive
// over-relaxation with factor 1).
#pragma once

#include <algorithm>

#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/lcp/splitting.hpp"
#include "cpu_reference/oracle/lcp/watch.hpp"

namespace lockstep::oracle::lcp {

inline SolveReport symmetric_pgs(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z) {
  const auto relax = [&](Index i) {
    if (problem.m(i, i) <= 0) return;
    const double w = problem.m.row(i).dot(z) + problem.q[i];
    z[i] = std::clamp(z[i] - w / problem.m(i, i), problem.low_at(i, z), problem.high_at(i, z));
  };
  Watch watch(problem, limits);
  if (!may_sweep(problem, watch, z)) return watch.finish(z);
  do {
    for (Index i = 0; i < z.size(); ++i) relax(i);
    for (Index i = z.size(); i-- > 0;) relax(i);
  } while (!watch.stop_after(z));
  return watch.finish(z);
}

inline SolveReport symmetric_pgs(const Lcp& problem, const SolveLimits& limits, VectorXd& z) {
  return symmetric_pgs(boxed(problem), limits, z);
}

}  // namespace lockstep::oracle::lcp
