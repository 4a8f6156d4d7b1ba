// Frictional contact problems of others against time: every solver on every problem file of a folder, to two
// tolerances of the residual (docs/reference/error_measures.md) each from zero. CSV of medians over up to 21 runs,
// fewer of what takes long; what did not get there is in it too.
//   cone_solvers_bench FOLDER [--seconds S] [--solver NAME]... [--problem SUBSTRING_OF_NAME]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/error.hpp"
#include "host/problems/cone_file.hpp"

namespace {

using namespace lockstep;

std::vector<std::string> files_in(const std::string& folder, const std::string& substring) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && name.find(substring) != name.npos) files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

void print_row(const std::string& name, const oracle::ConeProblem& problem, const oracle::ConeSolver& solver,
               const oracle::SolveLimits& limits) {
  Eigen::VectorXd r;
  const oracle::SolveReport report = solver.solve(problem, limits, r);
  std::vector<double> times = {report.seconds};
  for (double sum = report.seconds; sum < 0.2 && times.size() < 21; sum += times.back()) {
    Eigen::VectorXd again;
    times.push_back(solver.solve(problem, limits, again).seconds);
  }
  std::ranges::nth_element(times, times.begin() + times.size() / 2);
  const oracle::ConeError error = oracle::cone_error(problem, r);
  fmt::print("{},{},{},{:g},{},{},{:.4f},{:.2e},{:.1e},{:.2e},{:.2e},{:.2e},{:.2e}\n", name, problem.contacts(),
             solver.name, limits.tolerance, oracle::stop_name(report.stop), report.iterations, times[times.size() / 2],
             error.residual, error.rounding, error.natural_map, error.natural_largest, error.alart_curnier,
             error.merit_1);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Residual against time for the solvers of frictional contact problems");
  std::string folder, substring;
  double seconds = 20;
  std::vector<std::string> names;
  std::vector<double> tolerances = {1e-4, 1e-8};
  app.add_option("folder", folder)->required();
  app.add_option("--seconds", seconds);
  app.add_option("--solver", names);
  app.add_option("--problem", substring);
  app.add_option("--tolerance", tolerances);
  CLI11_PARSE(app, argc, argv);
  fmt::print(
      "problem,contacts,solver,tolerance,stop,iterations,seconds,residual,rounding,natural_map,natural_largest,"
      "alart_curnier,merit_1\n");
  for (const std::string& path : files_in(folder, substring)) {
    const oracle::JointElimination elimination(read_cone_file(path).problem);
    for (const oracle::ConeSolver& solver : oracle::cone_solvers()) {
      if (!names.empty() && std::ranges::find(names, solver.name) == names.end()) continue;
      for (const double tolerance : tolerances)
        print_row(std::filesystem::path(path).filename().string(), elimination.reduced(), solver,
                  {.tolerance = tolerance, .iterations = 1'000'000, .seconds = seconds});
    }
  }
} catch (const std::exception& error) {
  fmt::print(stderr, "cone_solvers_bench: {}\n", error.what());
  return 2;
}
