#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/report_file.hpp"
#include "host/app/solve_options.hpp"
#include "host/error.hpp"
#include "host/problems/lcp_text.hpp"
#include "host/problems/solution_file.hpp"
#include "host/record/whole_file.hpp"

namespace lockstep::app {

namespace {

using namespace oracle;

struct LcpSolution {
  std::string_view solver;
  SolveReport report;
  lcp::VectorXd z;
};

// Iterations begin at `start`, direct methods have no use for it.
LcpSolution solve_with(const lcp::NamedSolver& solver, const lcp::Lcp& problem, const SolveLimits& limits,
                       const lcp::VectorXd& start) {
  LcpSolution solution = {solver.name, {}, start};
  solution.report = solver.solve(problem, limits, solution.z);
  return solution;
}

// Direct methods in the order of the matrices that they take, Newton where they are out of their reach, and all index
// sets of what is small: the first that arrives, else the best.
LcpSolution solve_by_any(const lcp::Lcp& problem, SolveLimits limits, const lcp::VectorXd& start) {
  std::optional<LcpSolution> best;
  for (const std::string_view name : {"lemke", "baraff", "keller", "fischer_newton", "enumeration"}) {
    const auto solver = std::ranges::find(lcp::solvers(), name, &lcp::NamedSolver::name);
    LcpSolution solution = solve_with(*solver, problem, limits, start);
    limits.seconds -= solution.report.seconds;
    if (!best || solution.report.residual < best->report.residual) best = std::move(solution);
    if (best->report.residual <= limits.tolerance || limits.seconds <= 0 || Interrupt::asked()) break;
  }
  return *best;
}

}  // namespace

std::vector<std::string> lcp_solver_names() {
  std::vector<std::string> names;
  for (const lcp::NamedSolver& solver : lcp::solvers()) names.emplace_back(solver.name);
  return names;
}

void solve_lcp(const SolveOptions& options) {
  if (solution_is_hdf5(options))
    throw Error(Failure::input, options.solution,
                "solutions of linear complementarity problems are texts; choose .dat");
  expect_writable(options.solution, "the solution", "z ");
  ReportFile report(options.report);
  const lcp::Lcp problem = read_lcp_text(options.problem);
  const auto named = std::ranges::find(lcp::solvers(), options.solver, &lcp::NamedSolver::name);
  if (named == lcp::solvers().end() && options.solver != "auto")
    throw Error(Failure::input, options.problem,
                fmt::format("is a linear complementarity problem, and {} is not for those; try {}", options.solver,
                            fmt::join(lcp_solver_names(), ", ")));
  Interrupt::defer();
  const lcp::VectorXd start =
      options.guess.empty() ? lcp::VectorXd() : read_solution_text(options.guess, problem.size());
  const LcpSolution solution = named != lcp::solvers().end() ? solve_with(*named, problem, options.limits, start)
                                                             : solve_by_any(problem, options.limits, start);
  const nlohmann::ordered_json json = {{"problem", options.problem},
                                       {"form", "linear complementarity"},
                                       {"unknowns", problem.size()},
                                       {"solver", solution.solver},
                                       {"tolerance", options.limits.tolerance},
                                       {"stop", end_of(options, solution.report)},
                                       {"converged", solution.report.residual <= options.limits.tolerance},
                                       {"iterations", solution.report.iterations},
                                       {"seconds", solution.report.seconds},
                                       {"residual", solution.report.residual},
                                       {"solution", std::vector<double>(solution.z.begin(), solution.z.end())}};
  report.write(json.dump(2) + "\n");
  if (!options.solution.empty())
    replace_file(options.solution, encode_solution_text(solution.z, problem.m * solution.z + problem.q));
  if (!options.quiet) {
    const auto row = [](const char* label, const std::string& value) { fmt::print("  {:<26}{}\n", label, value); };
    fmt::print("{}\n", options.problem);
    row("problem", fmt::format("linear complementarity, {} unknowns", problem.size()));
    row("solver", std::string(solution.solver));
    row("stopped by", end_of(options, solution.report));
    row("iterations", fmt::format("{}", solution.report.iterations));
    row("time", fmt::format("{:.4g} s", solution.report.seconds));
    row("residual", fmt::format("{:.3g}", solution.report.residual));
  }
  expect_solved(options, std::string(solution.solver), solution.report);
}

}  // namespace lockstep::app
