#include "host/app/oracle_run.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/joints/mixed.hpp"
#include "host/error.hpp"
#include "host/scene/compile_particles.hpp"
#include "host/scene/friction_pairs.hpp"

namespace lockstep::app {

namespace {

std::string oracle_descriptions() {
  std::string text =
      "Oracles solve the constraint system of each sub-step in double, on the reference, to the residual --tolerance\n"
      "(1e-10 unless given) in --iterations at most (100000):\n";
  for (const oracle::ConeSolver& solver : oracle::cone_solvers())
    text += fmt::format("  {:<20}{}\n", solver.name, solver.description);
  text += "Those that take motors, limits and springs of joints too:\n";
  for (const oracle::MixedSolver& solver : oracle::mixed_solvers())
    text += fmt::format("  {:<20}{}\n", solver.name, solver.description);
  return text +
         "  impulse_based       joints closed at the end of each sub-step, by predicting it; contacts beside them\n"
         "Other models:\n"
         "  pyramid_NAME        Model-LCP, friction in a pyramid of --directions sides, by enumeration, lemke, "
         "keller,\n"
         "                      baraff, murty, jacobi, damped_jacobi, pgs, psor, pgs_sm, nncg or fischer_newton\n"
         "  box_NAME            the boxed model, by baraff or one of those after murty\n"
         "  reduced_NAME        joints in reduced coordinates, which never open, with cones by one of the first names\n"
         "  reduced_pyramid_NAME  the same with friction pyramids (Model-DCA-LCP); also as mixed problems with "
         "velocities\n"
         "                      of some bodies, by reduced_mlcp1_fischer_newton and reduced_mlcp2_fischer_newton\n"
         "docs/solvers_oracle.md and docs/lcp.md say which one when.\n";
}

}  // namespace

void add_oracle_options(CLI::App& command, OracleOptions& options) {
  command.add_option("--directions", options.directions, "Sides of the friction pyramid of --solver pyramid_NAME")
      ->check(CLI::Range(3, 256))
      ->capture_default_str();
  command.footer(oracle_descriptions() +
                 "Example:\n  lockstep run spheres8000 --steps 120 --report out.json\n"
                 "  lockstep run incline --solver auto --tolerance 1e-12");
}

void prepare_for_oracle(const OracleOptions& oracle, SceneOptions& options, Scene& scene) {
  const auto expect = [&](bool good, const char* option, const char* what) {
    if (!good) throw Error(Failure::input, option, fmt::format("{} is an oracle, {}", oracle.solver, what));
  };
  const auto given = [&](const char* name) {
    const auto found = options.settings.find(name);
    return found == options.settings.end() ? std::string() : found->second;
  };
  expect(options.device == "auto" || options.device == "reference", "--device",
         "which runs on the reference only; leave --device out");
  expect(given("precision") != "float", "--precision", "which works in double only; leave --precision out");
  expect(given("friction_model") != "patches", "--friction-model",
         "for which friction is at each contact; leave --friction-model out");
  expect(std::ranges::none_of(friction_pairs_of(scene), &PairFriction::rubs_further), "--solver",
         "whose cones know no torsional or rolling friction and no grain, which materials of this scene have; leave "
         "--solver out");
  expect(!is_penalty(scene), "--solver", "and springs between particles leave it nothing to solve; leave --solver out");
  expect(!scene.settings.sleeping, "--sleeping", "and solves for everybody; give --sleeping off");
  options.device = "reference";
  Settings& settings = scene.settings;
  use_oracle(settings);
  apply_given(options, settings, {"substeps", "iterations", "tolerance"});
  expect(tolerance_of(settings) > 0, "--tolerance", "which needs a residual > 0 to end at");
}

void expect_all_solved(const std::string& scene, const OracleOptions& oracle, double tolerance,
                       const Unsolved& unsolved) {
  if (unsolved.count == 0) return;
  throw Error(Failure::comparison, scene,
              fmt::format("{} {}; try another --solver, more --iterations or a larger --tolerance", oracle.solver,
                          in_words(unsolved, tolerance)));
}

}  // namespace lockstep::app
