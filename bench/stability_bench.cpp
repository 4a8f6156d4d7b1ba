// What it costs to stand still: a scene that is built at rest, over solvers and sub-steps. CSV of time, how far the
// body that moved most has come, how deep shapes overlap in the last second and how much they move in it.
// Where the scene names the solver, sub-steps and sweeps that are not given are those of the scene.
//   stability_bench SCENE [--device D] [--steps N] [--solver NAME]... [--substeps N]... [--iterations N]...
//   [--frequency HZ]...
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "host/cases/rest.hpp"
#include "host/scene/read.hpp"
#include "host/scene/spring.hpp"

namespace {

using namespace lockstep;

// The frequency of contacts that is used, Hz.
std::string frequency_of(const Settings& settings) {
  if (settings.solver != Solver::small_steps) return "none";
  return fmt::format("{:g}",
                     usable_frequency(settings.dt / substeps_of(settings), settings.contact_frequency.value_or(1e9)));
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Time against stability of a scene that should stand");
  std::string name, device = "auto", precision = "float";
  u32 steps = 0;
  std::vector<Solver> solvers = {Solver::gauss_seidel, Solver::small_steps};
  std::vector<u32> substeps, iterations;
  std::vector<double> frequencies, dampings;
  app.add_option("scene", name)->required();
  app.add_option("--device", device);
  app.add_option("--precision", precision)->check(CLI::IsMember({"float", "double"}));
  app.add_option("--steps", steps);
  app.add_option("--solver", solvers)
      ->transform(CLI::CheckedTransformer(
          std::vector<std::pair<std::string, Solver>>(std::begin(solver_names), std::end(solver_names))));
  app.add_option("--substeps", substeps);
  app.add_option("--iterations", iterations);
  app.add_option("--frequency", frequencies);
  app.add_option("--damping", dampings);
  CLI11_PARSE(app, argc, argv);
  fmt::print(
      "scene,solver,substeps,iterations,frequency,damping,ms,moved_mm,mean_depth_mm,deepest_mm,deepest_ever_mm,kinetic_"
      "j\n");
  for (const Solver solver : solvers) {
    Scene scene = read_scene(name);
    if (scene.settings.solver != solver) replace_solver(scene.settings, solver);
    if (steps > 0) scene.settings.steps = steps;
    const Settings usual = scene.settings;
    for (const u32 s : substeps.empty() ? std::vector<u32>{substeps_of(usual)} : substeps) {
      for (const u32 i : iterations.empty() ? std::vector<u32>{iterations_of(usual)} : iterations) {
        for (const double f :
             frequencies.empty() ? std::vector<double>{usual.contact_frequency.value_or(1e9)} : frequencies) {
          for (const double z : dampings.empty() ? std::vector<double>{usual.contact_damping} : dampings) {
            scene.settings.substeps = s;
            scene.settings.iterations = i;
            scene.settings.contact_frequency = f;
            scene.settings.contact_damping = z;
            const RestMeasures rest = measure_rest(scene, precision, select_device(device));
            fmt::print("{},{},{},{},{},{},{:.3f},{:.2f},{:.3f},{:.3f},{:.2f},{:.1e}\n", scene.name, name_of(solver), s,
                       i, frequency_of(scene.settings), z, rest.ms, rest.moved * 1e3, rest.mean_depth * 1e3,
                       rest.deepest * 1e3, rest.deepest_of_all * 1e3, rest.kinetic);
            std::fflush(stdout);
          }
        }
      }
    }
  }
} catch (const std::exception& error) {
  fmt::print(stderr, "stability_bench: {}\n", error.what());
  return 2;
}
