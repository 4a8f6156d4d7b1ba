// Semi-smooth Newton (Alart and Curnier 1991; Acary, Bremond, Huber 2018) with a line search on the function itself and
// a damping on the diagonal of W, relative to lambda_max(W_ii), that keeps the system regular where W is not: it grows
// where no step length helps and shrinks where whole steps do. Where no damping helps either, at a local minimum of the
// function, some sweeps of Gauss-Seidel lead away, twice as many each time. Such sweeps make the start, too.
#include <algorithm>
#include <cmath>

#include "cpu_reference/oracle/cone/newton_step.hpp"
#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/cone/start.hpp"
#include "cpu_reference/oracle/cone/watch.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::VectorXd;

constexpr double least_damping = 1e-12, most_damping = 1e2;

}  // namespace

SolveReport newton(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r) {
  Watch watch(problem, limits, 40);
  const VectorXd zero = VectorXd::Zero(problem.q.size());
  const NewtonProblem whole = {problem, watch.meter().mobility(), zero, zero};
  VectorXd x = start_of(problem, r), direction;
  SolveLimits sweeps = {.tolerance = limits.tolerance, .iterations = 20, .seconds = limits.seconds};
  if (!watch.look(x, 0)) nsgs(problem, sweeps, x);
  VectorXd u = whole.velocity(x);
  double damping = 1e-8, merit = newton_merit(whole, x, u);
  for (std::uint32_t iteration = 1; !watch.look(x, iteration - 1); ++iteration) {
    bool gained = false;
    if (newton_direction(whole, damping, x, u, direction)) {
      for (double step = 1; step > 1e-2 && !gained; step *= 0.5) {
        const VectorXd next = x + step * direction, next_u = whole.velocity(next);
        const double next_merit = newton_merit(whole, next, next_u);
        if (!(next_merit < (1 - 1e-3 * step) * merit)) continue;
        gained = true;
        x = next;
        u = next_u;
        merit = next_merit;
        if (step == 1) damping = std::max(least_damping, 0.1 * damping);
        if (step < 0.2) damping *= 10;
      }
    }
    if (gained) continue;
    damping = std::max(1e-6, 30 * damping);
    if (damping <= most_damping) continue;
    sweeps.iterations = std::min(2 * sweeps.iterations, 1000u);
    nsgs(problem, sweeps, x);
    u = whole.velocity(x);
    merit = newton_merit(whole, x, u);
    damping = 1e-2;
  }
  return watch.finish(r);
}

}  // namespace lockstep::oracle
