#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cpu_reference/oracle/cone/whole.hpp"
#include "cpu_reference/oracle/joints/mixed.hpp"
#include "host/app/command_files.hpp"
#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/options.hpp"
#include "host/app/report_file.hpp"
#include "host/app/solve_options.hpp"
#include "host/error.hpp"
#include "host/problems/cone_file.hpp"
#include "host/problems/lcp_text.hpp"
#include "host/problems/solution_file.hpp"
#include "host/record/whole_file.hpp"
#include "host/scene/json_node.hpp"

namespace lockstep::app {

namespace {

std::vector<std::string> solver_names_known() {
  std::vector<std::string> names;
  for (const oracle::ConeSolver& solver : oracle::cone_solvers()) names.emplace_back(solver.name);
  for (const oracle::MixedSolver& solver : oracle::mixed_solvers()) names.emplace_back(solver.name);
  for (std::string& name : lcp_solver_names()) names.push_back(std::move(name));
  return names;
}

std::string solver_descriptions() {
  std::string text = "Solvers of contact problems:\n";
  for (const oracle::ConeSolver& solver : oracle::cone_solvers())
    text += fmt::format("  {:<20}{}\n", solver.name, solver.description);
  text += "Of those in the global form, joints as a part of their own:\n";
  for (const oracle::MixedSolver& solver : oracle::mixed_solvers())
    text += fmt::format("  {:<20}{}\n", solver.name, solver.description);
  text += fmt::format("Solvers of linear complementarity problems (docs/theory/lcp.md):\n  auto, {}\n",
                      fmt::join(lcp_solver_names(), ", "));
  return text + "Example:\n  lockstep solve problem.hdf5 --solver admm --tolerance 1e-6";
}

Eigen::Index joint_rows(const oracle::ConeProblem& problem) { return problem.joints ? problem.joints->s.size() : 0; }

// Where the largest defect sits.
std::string worst_location(const ConeFile& file, const oracle::ConeError& error) {
  const std::uint32_t contacts = file.problem.contacts();
  if (error.worst < contacts) return fmt::format("contact {}", error.worst / file.contacts_in_problem());
  return fmt::format("joint block {}", error.worst - contacts);
}

// Of impulses from a file: those that the problem's own carries, and the guess. None where those of joints are missing.
std::optional<oracle::ConeError> error_of(const ConeFile& file, const std::optional<oracle::ConeImpulses>& impulses) {
  if (!impulses || impulses->l.size() != joint_rows(file.problem)) return {};
  return oracle::cone_error(file.problem, impulses->r, impulses->l);
}

struct Solved {
  ConeFile file;
  std::optional<oracle::ConeImpulses> guess;
  oracle::ConeSolution solution;
};

std::string to_json(const SolveOptions& options, const Solved& solved) {
  const auto& [file, guess, solution] = solved;
  const oracle::ConeError& error = solution.error;
  nlohmann::ordered_json json = {{"problem", options.problem},
                                 {"form", file.form},
                                 {"contacts", file.contacts()},
                                 {"joint_rows", joint_rows(file.problem)},
                                 {"solver", options.solver},
                                 {"tolerance", options.limits.tolerance},
                                 {"stop", end_of(options, solution.report)},
                                 {"converged", error.residual <= options.limits.tolerance},
                                 {"iterations", solution.report.iterations},
                                 {"seconds", solution.report.seconds},
                                 {"residual", error.residual},
                                 {"residual_floor", error.rounding},
                                 {"defect_velocity_max", error.defect_max},
                                 {"natural_map", error.natural_map},
                                 {"natural_largest", error.natural_largest},
                                 {"alart_curnier", error.alart_curnier},
                                 {"jean_moreau", error.jean_moreau},
                                 {"merit_1", error.merit_1}};
  for (const auto& [name, impulses] : {std::pair("stored", file.stored), std::pair("guess", guess)}) {
    const std::optional<oracle::ConeError> of = error_of(file, impulses);
    json[std::string(name) + "_residual"] = of ? nlohmann::json(of->residual) : nlohmann::json(nullptr);
    json[std::string(name) + "_natural_map"] = of ? nlohmann::json(of->natural_map) : nlohmann::json(nullptr);
  }
  return json.dump(2) + "\n";
}

void print_table(const SolveOptions& options, const Solved& solved) {
  const auto& [file, guess, solution] = solved;
  const oracle::ConeError& error = solution.error;
  const auto row = [](const char* label, const std::string& value) { fmt::print("  {:<26}{}\n", label, value); };
  const auto number = [&](const char* label, double value) { row(label, fmt::format("{:.3g}", value)); };
  fmt::print("{}\n", options.problem);
  row("problem",
      fmt::format("{}, {} contacts, {} rows of joints", file.form, file.contacts(), joint_rows(file.problem)));
  row("solver", options.solver);
  row("stopped by", end_of(options, solution.report));
  row("iterations", fmt::format("{}", solution.report.iterations));
  row("time", fmt::format("{:.4g} s", solution.report.seconds));
  row("residual", fmt::format("{:.3g}  (rounding alone {:.1g})", error.residual, error.rounding));
  row("largest defect velocity", fmt::format("{:.3g} m/s, {}", error.defect_max, worst_location(file, error)));
  number("natural map / |q|", error.natural_map);
  number("natural map / largest", error.natural_largest);
  number("Alart-Curnier / |q|", error.alart_curnier);
  number("Jean-Moreau / |q|", error.jean_moreau);
  number("FCLIB MERIT_1", error.merit_1);
  if (const auto of = error_of(file, file.stored)) number("residual of the stored", of->residual);
  if (const auto of = error_of(file, guess)) number("residual of the guess", of->residual);
}

oracle::ConeSolution solve_by_mixed(const ConeFile& file, const oracle::MixedSolver& solver,
                                    const oracle::SolveLimits& limits, const oracle::ConeImpulses& start) {
  if (!file.global)
    throw std::runtime_error("is in the local form, and mixed solvers need the bodies of the global one; try auto");
  const oracle::MixedProblem problem = {*file.global, oracle::SparseMatrix(file.global->m.rows(), 0), {}};
  oracle::MixedImpulses impulses = {start.r, start.l, {}};
  oracle::ConeSolution solution;
  solution.report = oracle::solve_mixed(problem, solver, limits, impulses);
  solution.r = impulses.r;
  solution.l = impulses.l;
  solution.error = oracle::cone_error(file.problem, solution.r, solution.l);
  return solution;
}

oracle::ConeSolution solve_by_name(const SolveOptions& options, const ConeFile& file,
                                   const oracle::ConeImpulses& start) {
  if (const oracle::MixedSolver* mixed = oracle::find_mixed_solver(options.solver))
    return solve_by_mixed(file, *mixed, options.limits, start);
  if (const oracle::ConeSolver* solver = oracle::find_cone_solver(options.solver))
    return oracle::solve_whole(file.problem, *solver, options.limits, start.r);
  throw std::runtime_error("is a contact problem, and " + options.solver +
                           " is for linear complementarity problems; try auto");
}

void write_solution(const SolveOptions& options, const Solved& solved) {
  if (options.solution.empty()) return;
  const ProblemSolution all = solution_of(solved.file, {solved.solution.r, solved.solution.l});
  replace_file(options.solution, solution_is_hdf5(options) ? encode_solution(all, read_whole_file(options.problem))
                                                           : encode_solution_text(all, solved.file.dimension));
}

void solve(const SolveOptions& options) {
  expect_separate({{"--report", options.report}, {"--solution", options.solution}}, {{"the problem", options.problem}});
  expect_separate({{"--report", options.report}}, {{"--guess", options.guess}});  // a solution may follow its guess
  if (is_lcp_text(options.problem)) return solve_lcp(options);
  expect_writable(options.solution, "the solution", solution_is_hdf5(options) ? "\x89HDF" : "r ");
  ReportFile report(options.report);
  Solved solved = {read_cone_file(options.problem), {}, {}};
  if (!options.guess.empty()) solved.guess = read_solution_file(options.guess, solved.file);
  Interrupt::defer();
  try {
    solved.solution = solve_by_name(options, solved.file, solved.guess.value_or(oracle::ConeImpulses{}));
  } catch (const std::runtime_error& error) {
    throw Error(Failure::input, options.problem, error.what());
  }
  oracle::SolveReport& outcome = solved.solution.report;
  outcome.residual = solved.solution.error.residual;  // of the whole problem, joints and all
  report.write(to_json(options, solved));
  write_solution(options, solved);
  if (!options.quiet) print_table(options, solved);
  expect_solved(options, options.solver, outcome);
}

}  // namespace

bool is_interrupted(const SolveOptions& options, const oracle::SolveReport& report) {
  return Interrupt::asked() && !(report.residual <= options.limits.tolerance);
}

std::string end_of(const SolveOptions& options, const oracle::SolveReport& report) {
  return is_interrupted(options, report) ? "interrupted" : std::string(oracle::stop_name(report.stop));
}

bool solution_is_hdf5(const SolveOptions& options) {
  return options.solution.ends_with(".hdf5") || options.solution.ends_with(".h5");
}

void expect_solved(const SolveOptions& options, const std::string& solver, const oracle::SolveReport& report) {
  if (report.residual <= options.limits.tolerance) return;
  if (is_interrupted(options, report))
    throw Error(Failure::comparison, options.problem,
                fmt::format("interrupted: {} had come to a residual of {:.3g}, {:.3g} was asked for", solver,
                            report.residual, options.limits.tolerance));
  throw Error(Failure::comparison, options.problem,
              fmt::format("{} left a residual of {:.3g}, {:.3g} was asked for ({}); try {}", solver, report.residual,
                          options.limits.tolerance, oracle::stop_name(report.stop),
                          report.stop == oracle::Stop::limit ? "more --iterations or --seconds"
                                                             : "another --solver or a larger --tolerance"));
}

void add_solve(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("solve", "Solve a contact or complementarity problem from a file, in double precision");
  const auto options = std::make_shared<SolveOptions>();
  command
      ->add_option("problem", options->problem,
                   "FCLIB file (.hdf5), or contact or complementarity problem as text (.dat)")
      ->required();
  command->add_option("--solver", options->solver, "Solver, from the lists below")
      ->check(CLI::Validator(
          [](const std::string& name) {
            const std::vector<std::string> names = solver_names_known();
            const bool is_known = std::ranges::find(names, name) != names.end();
            return is_known ? std::string()
                            : fmt::format("unknown solver {}; {}", quote(name), suggestion(name, names));
          },
          ""))
      ->type_name("NAME")
      ->capture_default_str();
  command->add_option("--tolerance", options->limits.tolerance, "Stop at this residual")
      ->check(positive)
      ->capture_default_str();
  command->add_option("--iterations", options->limits.iterations, "Stop after this many iterations")
      ->check(positive)
      ->capture_default_str();
  command->add_option("--seconds", options->limits.seconds, "Stop after this many seconds")
      ->check(positive)
      ->capture_default_str();
  add_file_option(*command, "--report", options->report, "Write the report to this JSON file");
  add_file_option(*command, "--solution", options->solution,
                  "Write impulses and velocities to this file: FCLIB if it ends in .hdf5, else text");
  command->add_option("--guess", options->guess, "Start from the impulses in this file, written by --solution");
  command->add_flag("--quiet", options->quiet, "Print no table");
  command->footer(solver_descriptions());
  command->callback([options] { solve(*options); });
}

}  // namespace lockstep::app
