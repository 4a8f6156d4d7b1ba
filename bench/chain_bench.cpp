// How well a scene of joints is held, against its cost: the largest separation of a joint and how far the energy leaves
// its first value, for settings of the solver.
//
//   chain_bench [--scene chain64] [--device reference|auto|...] [--solver NAME] [--steps 1200] [--substeps 8,16,32]
//               [--iterations 1,2]
//
// What is not given is that of the scene, or of the solver where another one is given.
//
// The energy is in parts of its range: what gravity can give to the bodies on their way from where they start to
// hanging straight down from the origin, the sum of m g times the distance from the origin.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>

#include "host/cases/swing.hpp"
#include "host/error.hpp"
#include "host/scene/read.hpp"

namespace {

using namespace lockstep;

struct Options {
  std::string scene = "chain64", device = "reference", precision = "float";
  std::optional<Solver> solver;
  u32 steps = 1200;
  double frequency = 0, damping = 0, correction = 0;
  std::vector<u32> substeps, iterations;
};

void run(const Scene& scene, const Options& options) {
  const Method as_it_is = {.name = scene.name, .ladder = {}};
  Trial trial(as_it_is, {}, options.precision, select_device(options.device));
  try {
    const Swung swung = swing(scene, options.steps * scene.settings.dt, trial);
    fmt::print("{:4} {:3}  separation {:.5f} m  energy {:+.4f} .. {:+.4f}  {:.4f} ms a step\n",
               substeps_of(scene.settings), iterations_of(scene.settings), swung.separation, -swung.lost, swung.gained,
               trial.ms_per_step());
  } catch (const Error& error) {
    fmt::print("{:4} {:3}  {}\n", substeps_of(scene.settings), iterations_of(scene.settings), error.what());
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Joint separation and energy against cost");
  app.add_option("--scene", options.scene, "A built-in scene or a file");
  app.add_option("--device", options.device, "reference, auto, or an index");
  app.add_option("--precision", options.precision, "float or double");
  app.add_option("--solver", options.solver, "Instead of the scene's")
      ->transform(CLI::CheckedTransformer(
          std::vector<std::pair<std::string, Solver>>(std::begin(solver_names), std::end(solver_names))));
  app.add_option("--steps", options.steps, "Time steps");
  app.add_option("--frequency", options.frequency, "joint_frequency instead of the scene's, Hz");
  app.add_option("--damping", options.damping, "joint_damping instead of the scene's");
  app.add_option("--correction", options.correction, "correction instead of the scene's (gauss_seidel)");
  app.add_option("--substeps", options.substeps, "Sub-steps to try")->delimiter(',');
  app.add_option("--iterations", options.iterations, "Sweeps to try")->delimiter(',');
  CLI11_PARSE(app, argc, argv);
  try {
    Scene scene = read_scene(options.scene);
    if (options.solver && *options.solver != scene.settings.solver) replace_solver(scene.settings, *options.solver);
    if (options.substeps.empty()) options.substeps = {substeps_of(scene.settings)};
    if (options.iterations.empty()) options.iterations = {iterations_of(scene.settings)};
    if (options.correction > 0) scene.settings.correction = options.correction;
    if (options.frequency > 0) scene.settings.joint_frequency = options.frequency;
    if (options.damping > 0) scene.settings.joint_damping = options.damping;
    for (const u32 substeps : options.substeps) {
      for (const u32 iterations : options.iterations) {
        scene.settings.substeps = substeps;
        scene.settings.iterations = iterations;
        run(scene, options);
      }
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
