// Which solver when, as found in bench/results/avx512-2core/cone_solvers.csv: Gauss-Seidel gains the first digits
// cheapest, so it begins. Then the ADMM, which needs the fewest iterations for the rest, Newton's method, which
// finishes what is well-posed, Gauss-Seidel again and the proximal point iteration take turns, each from the best so
// far and for so many iterations; in the next round for twice as many. The ADMM alone goes on gaining where thousands
// of contacts are redundant: it gets four times as many, and a second turn in a metric that lets impulses that do not
// matter move further. From its third turn without halving the residual on a solver sits out rounds: one, three, seven.
// What counts are iterations, not time: a problem has the same answer every time, unless the time runs out.
#include <algorithm>
#include <chrono>

#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/cone/start.hpp"
#include "host/stop_request.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::VectorXd;

constexpr std::uint32_t most_rounds = 12;

// Runs one solver after the other from the best so far.
class Relay {
 public:
  Relay(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r)
      : problem_(problem), limits_(limits), r_(r) {}

  bool finished() const {
    return report_.stop == Stop::solved || stop_asked() || left().seconds <= 0 || left().iterations == 0;
  }
  SolveLimits left() const {
    SolveLimits left = limits_;
    left.seconds -= seconds();
    left.iterations -= std::min(left.iterations, report_.iterations);
    return left;
  }

  using Solve = SolveReport (*)(const ConeProblem&, const SolveLimits&, VectorXd&);

  // Whether the residual was at least halved.
  bool run(Solve solve, std::uint32_t iterations, double tolerance = 0) {
    if (finished()) return false;
    const double before = report_.residual;
    const bool first = !started_;
    SolveLimits limits = left();
    limits.iterations = std::min(limits.iterations, iterations);
    limits.tolerance = std::max(limits.tolerance, tolerance);
    VectorXd x = r_;
    const SolveReport attempt = solve(problem_, limits, x);
    report_.iterations += attempt.iterations;
    report_.residuals.insert(report_.residuals.end(), attempt.residuals.begin(), attempt.residuals.end());
    if (!started_ || attempt.residual < report_.residual) {
      report_.residual = attempt.residual;
      r_ = x;
    }
    started_ = true;
    report_.stop = report_.residual <= limits_.tolerance ? Stop::solved : Stop::limit;
    return first || report_.residual <= 0.5 * before;
  }

  SolveReport finish() {
    if (!finished()) report_.stop = Stop::stalled;
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

// One of those that take turns.
struct Runner {
  Relay::Solve solve;
  std::uint32_t iterations, growth;  // of its first turn; from turn to turn
  std::uint32_t in_vain = 0, sits_out = 0;

  void run(Relay& relay) {
    if (sits_out > 0) {
      --sits_out;
      return;
    }
    in_vain = relay.run(solve, iterations) ? 0 : in_vain + 1;
    sits_out = in_vain < 3 ? 0 : (1u << (in_vain - 2)) - 1;
    iterations *= growth;
  }
};

}  // namespace

SolveReport solve_automatically(const ConeProblem& problem, const SolveLimits& limits, VectorXd& r) {
  r = start_of(problem, r);
  Relay relay(problem, limits, r);
  relay.run(gauss_seidel, 2000, 1e-4);
  relay.run(gauss_seidel, 100);
  Runner runners[] = {
      {admm, 1000, 4}, {newton, 10, 2}, {gauss_seidel, 1000, 2}, {proximal_point, 5, 2}, {fixed_metric_admm, 1000, 4}};
  for (std::uint32_t round = 0; round < most_rounds && !relay.finished(); ++round) {
    for (Runner& runner : runners) runner.run(relay);
  }
  return relay.finish();
}

}  // namespace lockstep::oracle
