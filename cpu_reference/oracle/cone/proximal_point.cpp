// Proximal point iteration (Rockafellar 1976; for Coulomb friction: Acary, Bremond, Huber 2018): r_k+1 is the solution,
// found by Newton's method from r_k, of the problem with
//   W + alpha_k D,   q - alpha_k D r_k,   D = diag(lambda_max(W_ii))
// which is positive definite whatever the rank of W. alpha shrinks where Newton's method gets along with it and grows
// where it does not.
#include <algorithm>
#include <cmath>

#include "cpu_reference/oracle/cone/newton_step.hpp"
#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/cone/start.hpp"
#include "cpu_reference/oracle/cone/watch.hpp"
#include "host/stop_request.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::VectorXd;

constexpr std::uint32_t most_steps = 25;  // of Newton for one outer iteration
constexpr double least_alpha = 1e-12, most_alpha = 1e3;

// Newton's method on one of the problems, to a share of the merit that it starts with. Returns its steps, 0 where it
// did not get there; `x` is the best that it found.
std::uint32_t inner_newton(const NewtonProblem& newton, VectorXd& x, double share) {
  VectorXd u = newton.velocity(x), direction;
  double merit = newton_merit(newton, x, u);
  const double wanted = share * merit;
  for (std::uint32_t step = 1; step <= most_steps && !stop_asked(); ++step) {
    if (!newton_direction(newton, 0, x, u, direction)) return 0;
    bool gained = false;
    for (double length = 1; length > 1e-2 && !gained; length *= 0.5) {
      const VectorXd next = x + length * direction, next_u = newton.velocity(next);
      const double next_merit = newton_merit(newton, next, next_u);
      if (!(next_merit < (1 - 1e-3 * length) * merit)) continue;
      gained = true;
      x = next;
      u = next_u;
      merit = next_merit;
    }
    if (!gained) return 0;
    if (merit <= wanted) return step;
  }
  return 0;
}

}  // namespace

SolveReport proximal_point(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r) {
  Watch watch(problem, limits, 60);
  const VectorXd& mobility = watch.meter().mobility();
  VectorXd d(problem.q.size());
  for (std::uint32_t i = 0; i < problem.contacts(); ++i) d.segment<3>(3 * i).setConstant(mobility[i]);
  VectorXd x = start_of(problem, r);
  if (!watch.look(x, 0))  // a start that knows about which contacts are open
    nsgs(problem, {.tolerance = limits.tolerance, .iterations = 20, .seconds = limits.seconds}, x);
  double alpha = 1e-2;
  for (std::uint32_t outer = 1; !watch.look(x, outer - 1); ++outer) {
    VectorXd next = x;
    const std::uint32_t steps = inner_newton({problem, mobility, alpha * d, x}, next, 1e-2);
    if (steps > 0) {
      x = next;
      if (steps <= 6) alpha = std::max(least_alpha, 0.1 * alpha);
    } else {
      alpha = std::min(most_alpha, 10 * alpha);
    }
  }
  return watch.finish(r);
}

}  // namespace lockstep::oracle
