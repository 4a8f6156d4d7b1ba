// What it costs to stand still: a scene that is built at rest, over solvers and sub-steps. CSV of time, how far the
// body that moved most has come, how deep shapes overlap in the last second and how much they move in it.
//   stability_bench SCENE [--steps N] [--solver NAME]... [--substeps N]... [--iterations N]... [--frequency HZ]...
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "host/backends/device_backend.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/error.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace {

using namespace lockstep;
using Clock = std::chrono::steady_clock;

struct Stood {
  double ms = 0;              // of a step, median
  double moved = 0;           // m, of the body that moved most
  double mean_depth = 0;      // m, over contacts that touch, the mean over the last second
  double deepest = 0;         // m, in the last second
  double deepest_of_all = 0;  // m
  double kinetic = 0;         // J a body, the largest in the last second
};

Stood stand(const Scene& scene, const std::string& device_name) {
  const InitialState<float> state = compile<float>(scene);
  std::vector<Vec4<float>> start = state.buffers.positions;
  const auto device = select_device(device_name);
  std::unique_ptr<Backend<float>> backend;
  if (device)
    backend = std::make_unique<DeviceBackend<float>>(state, *device);
  else
    backend = std::make_unique<ReferenceBackend<float>>(state);
  Simulation<float> simulation(std::move(backend), state.params);
  Backend<float>& b = simulation.backend();
  const u32 second = std::max(1u, static_cast<u32>(1 / scene.settings.dt));
  std::vector<double> ms;
  Stood stood;
  u32 measured = 0;
  for (u32 i = 0; i < scene.settings.steps; ++i) {
    const auto begin = Clock::now();
    simulation.step();
    ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    const bool last = i + second >= scene.settings.steps;
    if (!last && i % 10 != 0) continue;
    const auto wanted = measured_buffers(b.features());
    const Measures m = measure(b.download(wanted), b.sizes(), b.features(), simulation.counters());
    stood.deepest_of_all = std::max(stood.deepest_of_all, m.penetration.max);
    if (!last) continue;
    ++measured;
    stood.mean_depth += m.penetration.mean;
    stood.deepest = std::max(stood.deepest, m.penetration.max);
    stood.kinetic = std::max(stood.kinetic, m.worlds[0].kinetic / scene.bodies.size());
  }
  stood.mean_depth /= measured;
  constexpr Buffer wanted[] = {Buffer::positions};
  const auto& end = b.download(wanted).positions;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const double d[3] = {double(end[i].x) - start[i].x, double(end[i].y) - start[i].y, double(end[i].z) - start[i].z};
    stood.moved = std::max(stood.moved, std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
  }
  std::ranges::nth_element(ms, ms.begin() + static_cast<long>(ms.size() / 2));
  stood.ms = ms[ms.size() / 2];
  return stood;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Time against stability of a scene that should stand");
  std::string name, device = "auto";
  u32 steps = 0;
  std::vector<Solver> solvers = {Solver::gauss_seidel, Solver::small_steps};
  std::vector<u32> substeps, iterations;
  std::vector<double> frequencies, dampings;
  app.add_option("scene", name)->required();
  app.add_option("--device", device);
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
    use_solver(scene.settings, solver);
    if (steps > 0) scene.settings.steps = steps;
    const Settings usual = scene.settings;
    for (const u32 s : substeps.empty() ? std::vector<u32>{usual.substeps} : substeps) {
      for (const u32 i : iterations.empty() ? std::vector<u32>{usual.iterations} : iterations) {
        for (const double f : frequencies.empty() ? std::vector<double>{usual.contact_frequency} : frequencies) {
          for (const double z : dampings.empty() ? std::vector<double>{usual.contact_damping} : dampings) {
            scene.settings.substeps = s;
            scene.settings.iterations = i;
            scene.settings.contact_frequency = f;
            scene.settings.contact_damping = z;
            const Stood stood = stand(scene, device);
            fmt::print("{},{},{},{},{},{},{:.3f},{:.2f},{:.3f},{:.3f},{:.2f},{:.1e}\n", scene.name, name_of(solver), s,
                       i, f, z, stood.ms, stood.moved * 1e3, stood.mean_depth * 1e3, stood.deepest * 1e3,
                       stood.deepest_of_all * 1e3, stood.kinetic);
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
