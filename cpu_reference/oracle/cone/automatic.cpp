// Which solver when, as found in bench/results/avx512-2core/cone_solvers.csv: Gauss-Seidel gains the first digits
// cheapest, so it begins. Then the ADMM, which needs the fewest iterations for the rest, Newton's method, which
// finishes what is well-posed, Gauss-Seidel again and the proximal point iteration take turns, each from the best so
// far and for so many iterations; in the next round for twice as many. What counts are iterations, not time: a problem
// has the same answer every time, unless the time runs out.
#include <algorithm>
#include <chrono>

#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/cone/start.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::VectorXd;

constexpr std::uint32_t most_effort = 64;

// Runs one solver after the other from the best so far.
class Relay {
 public:
  Relay(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r)
      : problem_(problem), limits_(limits), r_(r) {}

  bool finished() const { return report_.stop == Stop::tolerance || left().seconds <= 0 || left().iterations == 0; }
  SolveLimits left() const {
    SolveLimits left = limits_;
    left.seconds -= seconds();
    left.iterations -= std::min(left.iterations, report_.iterations);
    return left;
  }

  using Solve = SolveReport (*)(const ConeProblem&, const SolveLimits&, VectorXd&);

  void run(Solve solve, std::uint32_t iterations, double tolerance = 0) {
    if (finished()) return;
    SolveLimits limits = left();
    limits.iterations = std::min(limits.iterations, iterations);
    limits.tolerance = std::max(limits.tolerance, tolerance);
    VectorXd x = r_;
    const SolveReport part = solve(problem_, limits, x);
    report_.iterations += part.iterations;
    report_.residuals.insert(report_.residuals.end(), part.residuals.begin(), part.residuals.end());
    if (!started_ || part.residual < report_.residual) {
      report_.residual = part.residual;
      r_ = x;
    }
    started_ = true;
    report_.stop = report_.residual <= limits_.tolerance ? Stop::tolerance : Stop::limit;
  }

  SolveReport finish() {
    if (report_.stop != Stop::tolerance && left().seconds > 0 && left().iterations > 0) report_.stop = Stop::stall;
    report_.seconds = seconds();
    return report_;
  }

 private:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  using Clock = std::chrono::steady_clock;
  const Clock::time_point start_ = Clock::now();
  const ConeProblem& problem_;
  const SolveLimits limits_;
  VectorXd& r_;
  SolveReport report_;
  bool started_ = false;
};

SolveReport gauss_seidel(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r) {
  return nsgs(problem, limits, r);
}

}  // namespace

SolveReport solve_automatically(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r) {
  r = start_of(problem, r);
  Relay relay(problem, limits, r);
  relay.run(gauss_seidel, 2000, 1e-4);
  relay.run(gauss_seidel, 100);
  for (std::uint32_t effort = 1; effort <= most_effort && !relay.finished(); effort *= 2) {
    relay.run(admm, 1000 * effort);
    relay.run(newton, 10 * effort);
    relay.run(gauss_seidel, 1000 * effort);
    relay.run(proximal_point, 5 * effort);
  }
  return relay.finish();
}

}  // namespace lockstep::oracle
