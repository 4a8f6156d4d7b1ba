// Lockstep beside Bullet on one scene, in turns within one run: milliseconds a step, overlap and how far bodies have
// come, as CSV.
//   peers_bench [SCENE] [--steps N] [--repetitions N] [--threads N] [--solver NAME] [--substeps N] [--iterations N]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <numeric>
#include <optional>

#include "bench/bullet_world.hpp"
#include "bench/overlap.hpp"
#include "host/backends/device_backend.hpp"
#include "host/error.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace {

using namespace lockstep;
using Clock = std::chrono::steady_clock;

struct Result {
  std::vector<double> ms;  // of each step
  std::vector<bench::BodyPose> poses;
};

/// Steps with a function and keeps the time of each call.
template <class Step>
std::vector<double> time_steps(u32 steps, Step&& step) {
  std::vector<double> ms;
  for (u32 i = 0; i < steps; ++i) {
    const auto begin = Clock::now();
    step();
    ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
  }
  return ms;
}

Result run_lockstep(const Scene& scene, u32 threads) {
  const auto device = select_device("auto");
  if (!device) throw Error(Failure::device, "peers_bench", "there is no OpenCL device to measure");
  const auto state = compile<float>(scene);
  DeviceOptions options;
  options.threads = threads;
  Simulation<float> simulation(std::make_unique<DeviceBackend<float>>(state, *device, options), state.params);
  Result result;
  result.ms = time_steps(scene.settings.steps, [&] { simulation.step(); });
  constexpr Buffer wanted[] = {Buffer::positions, Buffer::orientations};
  const Buffers<float>& b = simulation.backend().download(wanted);
  for (std::size_t i = 0; i < b.positions.size(); ++i) {
    const Vec4<float>&x = b.positions[i], &q = b.orientations[i];
    result.poses.push_back({{x.x, x.y, x.z}, {q.x, q.y, q.z, q.w}});
  }
  return result;
}

Result run_bullet(const Scene& scene) {
  bench::BulletWorld world(scene);
  Result result;
  result.ms = time_steps(scene.settings.steps, [&] { world.step(); });
  result.poses = world.poses();
  return result;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// One row: the medians over the repetitions of the mean step, of the mean of the last 100 and of the slowest
/// percentile.
void print(const std::string& engine, const Scene& scene, const std::vector<Result>& results) {
  std::vector<double> mean, tail, slow;
  for (const Result& result : results) {
    const auto count = static_cast<std::ptrdiff_t>(std::min<std::size_t>(100, result.ms.size()));
    mean.push_back(std::accumulate(result.ms.begin(), result.ms.end(), 0.0) / result.ms.size());
    tail.push_back(std::accumulate(result.ms.end() - count, result.ms.end(), 0.0) / count);
    std::vector<double> sorted = result.ms;
    std::sort(sorted.begin(), sorted.end());
    slow.push_back(sorted[sorted.size() * 99 / 100]);
  }
  const bench::Overlap overlap = bench::measure_overlap(scene, results.back().poses);
  fmt::print("{},{},{},{},{},{:.3f},{:.3f},{:.3f},{:.2f},{:.3f},{},{:.4f}\n", engine, scene.name, scene.bodies.size(),
             scene.settings.steps, results.size(), median(mean), median(tail), median(slow), 1e3 * overlap.deepest,
             1e3 * overlap.mean, overlap.pairs, bench::farthest_moved(scene, results.back().poses));
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App program("Lockstep beside Bullet on one scene, in turns within one run");
  std::string name = "spheres8000";
  u32 steps = 0, repetitions = 3, threads = 0, substeps = 0, iterations = 0;
  std::optional<Solver> solver;
  program.add_option("scene", name, "a built-in scene or a file")->capture_default_str();
  program.add_option("--steps", steps, "steps instead of the scene's");
  program.add_option("--repetitions", repetitions, "runs of each engine")->capture_default_str();
  program.add_option("--threads", threads, "compute units that Lockstep may use (Bullet uses one thread)");
  program.add_option("--solver", solver, "Lockstep's solver instead of the scene's")
      ->transform(CLI::CheckedTransformer(
          std::vector<std::pair<std::string, Solver>>(std::begin(solver_names), std::end(solver_names))));
  program.add_option("--substeps", substeps, "Lockstep's sub-steps instead of the scene's");
  program.add_option("--iterations", iterations, "sweeps of Lockstep's solver instead of the scene's");
  CLI11_PARSE(program, argc, argv);

  Scene scene = read_scene(name);
  if (steps) scene.settings.steps = steps;
  if (solver) use_solver(scene.settings, *solver);
  if (substeps) scene.settings.substeps = substeps;
  if (iterations) scene.settings.iterations = iterations;
  std::vector<Result> ours, bullet;
  for (u32 i = 0; i < repetitions; ++i) {
    ours.push_back(run_lockstep(scene, threads));
    bullet.push_back(run_bullet(scene));
  }
  fmt::print(
      "engine,scene,bodies,steps,repetitions,ms_step,ms_step_last_100,ms_step_p99,overlap_max_mm,overlap_mean_mm,"
      "overlapping_pairs,moved_m\n");
  print(fmt::format("lockstep ({} threads)", threads ? std::to_string(threads) : "all"), scene, ours);
  print("bullet (1 thread)", scene, bullet);
} catch (const std::exception& error) {
  fmt::print(stderr, "peers_bench: {}\n", error.what());
  return 2;
}
