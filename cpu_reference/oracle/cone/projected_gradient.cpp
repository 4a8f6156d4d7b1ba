// Projected gradient with De Saxce's fixed point renewed in each iteration:
//   r <- P_K(r - step rho u^),   u^ = W r + q + mu |u_t| n,   rho_i = 1 / lambda_max(W_ii)
// The step is halved until the quadratic f(r) = 1/2 r W r + (q + shift) r has the decrease that the step promises
//   f(r') <= f(r) + g d + |d|^2 / (2 step),   d = r' - r
// (here: d W d <= |d|^2 / step), and is tried a little longer in the next iteration.
#include "cpu_reference/oracle/cone/gradient.hpp"
#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/cone/start.hpp"
#include "cpu_reference/oracle/cone/watch.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::VectorXd;

}  // namespace

SolveReport projected_gradient(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r) {
  Watch watch(problem, limits);
  const VectorXd& mobility = watch.meter().mobility();
  VectorXd x = start_of(problem, r), change_of_u = problem.w.times(x);
  double step = 1;
  for (std::uint32_t iteration = 1; !watch.look_seldom(x, iteration - 1); ++iteration) {
    const VectorXd u = change_of_u + problem.q, g = u + de_saxce_shift(problem, u);
    for (step *= 1.2;; step *= 0.5) {
      const VectorXd next = gradient_step(problem, mobility, x, g, step), d = next - x, w_d = problem.w.times(d);
      const double bend = d.dot(w_d), length = squared_length(mobility, d);
      if (bend > length / step && step > 1e-12) continue;
      x = next;
      change_of_u += w_d;
      break;
    }
    if (iteration % 100 == 0) change_of_u = problem.w.times(x);  // of what rounding added up
  }
  return watch.finish(r);
}

}  // namespace lockstep::oracle
