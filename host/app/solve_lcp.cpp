#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "host/app/report_file.hpp"
#include "host/app/solve_options.hpp"
#include "host/error.hpp"
#include "host/problems/lcp_text.hpp"

namespace lockstep::app {

namespace {

using namespace oracle;

struct LcpAnswer {
  std::string_view solver;
  SolveReport report;
  lcp::VectorXd z;
};

LcpAnswer solve_with(const lcp::NamedSolver& solver, const lcp::Lcp& problem, const SolveLimits& limits) {
  LcpAnswer answer = {solver.name, {}, {}};
  answer.report = solver.solve(problem, limits, answer.z);
  return answer;
}

// Direct methods in the order of the matrices that they take, Newton where they are out of their reach, and all index
// sets of what is small: the first that arrives, else the best.
LcpAnswer solve_by_any(const lcp::Lcp& problem, SolveLimits limits) {
  std::optional<LcpAnswer> best;
  for (const std::string_view name : {"lemke", "baraff", "keller", "fischer_newton", "enumeration"}) {
    const auto solver = std::ranges::find(lcp::solvers(), name, &lcp::NamedSolver::name);
    LcpAnswer answer = solve_with(*solver, problem, limits);
    limits.seconds -= answer.report.seconds;
    if (!best || answer.report.residual < best->report.residual) best = std::move(answer);
    if (best->report.residual <= limits.tolerance || limits.seconds <= 0) break;
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
  ReportFile report(options.report);
  const lcp::Lcp problem = read_lcp_text(options.problem);
  const auto named = std::ranges::find(lcp::solvers(), options.solver, &lcp::NamedSolver::name);
  if (named == lcp::solvers().end() && options.solver != "auto")
    throw Error(Failure::input, options.problem,
                fmt::format("is a linear complementarity problem, and {} is not for those; try {}", options.solver,
                            fmt::join(lcp_solver_names(), ", ")));
  const LcpAnswer answer = named != lcp::solvers().end() ? solve_with(*named, problem, options.limits)
                                                         : solve_by_any(problem, options.limits);
  const nlohmann::ordered_json json = {{"problem", options.problem},
                                       {"form", "linear complementarity"},
                                       {"unknowns", problem.size()},
                                       {"solver", answer.solver},
                                       {"tolerance", options.limits.tolerance},
                                       {"stop", stop_name(answer.report.stop)},
                                       {"converged", answer.report.residual <= options.limits.tolerance},
                                       {"iterations", answer.report.iterations},
                                       {"seconds", answer.report.seconds},
                                       {"residual", answer.report.residual},
                                       {"solution", std::vector<double>(answer.z.begin(), answer.z.end())}};
  report.write(json.dump(2) + "\n");
  if (!options.quiet) {
    const auto row = [](const char* label, const std::string& value) { fmt::print("  {:<26}{}\n", label, value); };
    fmt::print("{}\n", options.problem);
    row("problem", fmt::format("linear complementarity, {} unknowns", problem.size()));
    row("solver", std::string(answer.solver));
    row("stopped by", std::string(stop_name(answer.report.stop)));
    row("iterations", fmt::format("{}", answer.report.iterations));
    row("time", fmt::format("{:.4g} s", answer.report.seconds));
    row("residual", fmt::format("{:.3g}", answer.report.residual));
  }
  expect_solved(options, std::string(answer.solver), answer.report);
}

}  // namespace lockstep::app
