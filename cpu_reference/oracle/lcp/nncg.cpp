// Non-smooth non-linear conjugate gradients (Silcowitz-Hansen, Niebe, Erleben 2010, "A nonsmooth nonlinear conjugate
// gradient method for interactive contact force problems"). What a sweep of projected Gauss-Seidel changes is taken for
// a negative gradient, g = z - sweep(z), and Fletcher and Reeves' rule makes directions of it:
//   z <- sweep(z) + beta p,   beta = |g|^2 / |g before|^2,   p <- beta p - g,
// where beta > 1 starts anew, with p = 0. Lengths are those of z / s, so that they do not depend on units.
#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/lcp/splitting.hpp"

namespace lockstep::oracle::lcp {

SolveReport nncg(const BoxedLcp& problem, const SolveLimits& limits, VectorXd& z) {
  Watch watch(problem, limits);
  if (!may_sweep(problem, watch, z)) return watch.finish(z);
  VectorXd p = VectorXd::Zero(z.size());
  double before = 0;  // |g|^2
  bool stop = false;
  while (!stop) {
    VectorXd swept = z;
    gauss_seidel_sweep(problem, 1, swept);
    const VectorXd g = z - swept;
    const double current = g.cwiseQuotient(watch.measure().scale()).squaredNorm();
    const double beta = before > 0 ? current / before : 0;
    stop = watch.stop_after(swept);  // the direction may leave the box
    if (beta > 1) {
      p.setZero();
      z = swept;
    } else {
      z = swept + beta * p;
      p = beta * p - g;
    }
    before = current;
  }
  return watch.finish(z);
}

SolveReport nncg(const Lcp& problem, const SolveLimits& limits, VectorXd& z) { return nncg(boxed(problem), limits, z); }

}  // namespace lockstep::oracle::lcp
