// Lockstep beside Bullet on one scene, in turns within one run: milliseconds a step, overlap, how far bodies have come
// and joints have parted, peak memory of the process and what the parts of a step share of its time, as CSV.
//   peers_bench [SCENE] [--steps N] [--repetitions N] [--threads N,...] [--solver NAME] [--substeps N] [--iterations N]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "bench/bullet_world.hpp"
#include "bench/median.hpp"
#include "bench/overlap.hpp"
#include "host/backends/device_backend.hpp"
#include "host/cases/subprocess.hpp"
#include "host/error.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace {

using namespace lockstep;
using bench::median;
using Clock = std::chrono::steady_clock;

struct Result {
  std::vector<double> ms;  // of each step
  std::vector<bench::BodyPose> poses;
  double separation = 0;   // largest of any joint at any step, m
  double peak_memory = 0;  // bytes
};

/// Steps with a function and keeps the time of each call; after each, outside of it, looks at the joints.
template <class Step, class Poses>
nlohmann::json time_steps(const Scene& scene, Step&& step, Poses&& poses) {
  std::vector<double> ms;
  std::vector<std::array<double, 7>> last;
  double separation = 0;
  for (u32 i = 0; i < scene.settings.steps; ++i) {
    const auto begin = Clock::now();
    step();
    ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    if (!scene.joints.empty()) separation = std::max(separation, bench::joint_separation(scene, poses()));
  }
  for (const auto& [x, q] : poses()) last.push_back({x[0], x[1], x[2], q[0], q[1], q[2], q[3]});
  return {{"ms", ms}, {"poses", last}, {"separation", separation}};
}

/// In a process of its own, so that engines do not share memory.
Result run(const std::function<nlohmann::json()>& steps) {
  Result result;
  const nlohmann::json found = run_in_subprocess(steps, &result.peak_memory);
  result.ms = found["ms"].get<std::vector<double>>();
  result.separation = found["separation"];
  for (const auto& p : found["poses"].get<std::vector<std::array<double, 7>>>())
    result.poses.push_back({{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}});
  return result;
}

std::unique_ptr<DeviceBackend<float>> open_backend(const InitialState<float>& state, u32 threads, bool profile) {
  const auto device = select_device("auto");
  if (!device) throw Error(Failure::device, "peers_bench", "there is no OpenCL device to measure");
  DeviceOptions options;
  options.threads = threads;
  options.profile = profile;
  return std::make_unique<DeviceBackend<float>>(state, *device, options);
}

Result run_lockstep(const Scene& scene, u32 threads) {
  return run([&] {
    const auto state = compile<float>(scene);
    Simulation<float> simulation(open_backend(state, threads, false), state.params);
    const auto poses = [&] {
      constexpr Buffer wanted[] = {Buffer::positions, Buffer::orientations};
      const Buffers<float>& b = simulation.backend().download(wanted);
      std::vector<bench::BodyPose> found;
      for (std::size_t i = 0; i < b.positions.size(); ++i) {
        const Vec4<float>&x = b.positions[i], &q = b.orientations[i];
        found.push_back({{x.x, x.y, x.z}, {q.x, q.y, q.z, q.w}});
      }
      return found;
    };
    return time_steps(
        scene, [&] { simulation.step(); }, poses);
  });
}

Result run_bullet(const Scene& scene) {
  return run([&] {
    bench::BulletWorld world(scene);
    return time_steps(
        scene, [&] { world.step(); }, [&] { return world.poses(); });
  });
}

/// What the parts of a step share of its device time, in percent: candidate pairs, contacts of them, colours and
/// blocks, sub-steps, the rest.
std::string shares(const Scene& scene, u32 threads) {
  const std::vector<double> seconds = run_in_subprocess([&]() -> nlohmann::json {
    const auto state = compile<float>(scene);
    Simulation<float> simulation(open_backend(state, threads, true), state.params);
    simulation.step();  // warms up
    const auto first = simulation.backend().stage_seconds();
    for (u32 i = 1; i < scene.settings.steps; ++i) simulation.step();
    const auto last = simulation.backend().stage_seconds();
    std::vector<double> groups(5);
    for (u32 s = 0; s < stage_count; ++s) {
      const auto is_in = [s](Stage from, Stage to) { return s >= u32(from) && s <= u32(to); };
      const u32 group = is_in(Stage::update_bounds, Stage::search_tree)            ? 0
                        : is_in(Stage::collide, Stage::collide)                    ? 1
                        : is_in(Stage::match_contacts, Stage::pack_points)         ? 2
                        : is_in(Stage::integrate_velocities, Stage::mark_touching) ? 3
                                                                                   : 4;
      groups[group] += last[s] - first[s];
    }
    return groups;
  });
  const double sum = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  std::string text;
  for (const double group : seconds) text += fmt::format(",{:.0f}", 100 * group / sum);
  return text;
}

/// One row: the medians over the repetitions of the mean step, of the mean of the last 100, of the slowest
/// percentile and of the memory.
void print(const std::string& engine, const Scene& scene, const std::vector<Result>& results,
           const std::string& shares) {
  std::vector<double> mean, tail, slow, memory;
  for (const Result& result : results) {
    const auto count = static_cast<std::ptrdiff_t>(std::min<std::size_t>(100, result.ms.size()));
    mean.push_back(std::accumulate(result.ms.begin(), result.ms.end(), 0.0) / result.ms.size());
    tail.push_back(std::accumulate(result.ms.end() - count, result.ms.end(), 0.0) / count);
    std::vector<double> sorted = result.ms;
    std::sort(sorted.begin(), sorted.end());
    slow.push_back(sorted[sorted.size() * 99 / 100]);
    memory.push_back(result.peak_memory);
  }
  const bench::Overlap overlap = bench::measure_overlap(scene, results.back().poses);
  fmt::print("{},{},{},{},{},{:.3f},{:.3f},{:.3f},{:.2f},{:.3f},{},{:.4f},{:.1f},{:.0f}{}\n", engine, scene.name,
             scene.bodies.size(), scene.settings.steps, results.size(), median(mean), median(tail), median(slow),
             1e3 * overlap.deepest, 1e3 * overlap.mean, overlap.pairs,
             bench::farthest_moved(scene, results.back().poses), 1e3 * results.back().separation, 1e-6 * median(memory),
             shares);
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App program("Lockstep beside Bullet on one scene, in turns within one run");
  std::string name = "spheres8000";
  u32 steps = 0, repetitions = 3, substeps = 0, iterations = 0;
  std::vector<u32> threads = {1, 2};
  std::optional<Solver> solver;
  program.add_option("scene", name, "a built-in scene or a file")->capture_default_str();
  program.add_option("--steps", steps, "steps instead of the scene's");
  program.add_option("--repetitions", repetitions, "runs of each engine")->capture_default_str();
  program.add_option("--threads", threads, "numbers of compute units that Lockstep may use (Bullet uses one)")
      ->delimiter(',')
      ->capture_default_str();
  program.add_option("--solver", solver, "Lockstep's solver instead of the scene's")
      ->transform(CLI::CheckedTransformer(
          std::vector<std::pair<std::string, Solver>>(std::begin(solver_names), std::end(solver_names))));
  program.add_option("--substeps", substeps, "Lockstep's sub-steps instead of the scene's");
  program.add_option("--iterations", iterations, "sweeps of Lockstep's solver instead of the scene's");
  CLI11_PARSE(program, argc, argv);

  Scene scene = read_scene(name);
  if (steps) scene.settings.steps = steps;
  if (solver) replace_solver(scene.settings, *solver);
  if (substeps) scene.settings.substeps = substeps;
  if (iterations) scene.settings.iterations = iterations;
  std::vector<std::vector<Result>> ours(threads.size());
  std::vector<Result> bullet;
  for (u32 i = 0; i < repetitions; ++i) {
    for (std::size_t t = 0; t < threads.size(); ++t) ours[t].push_back(run_lockstep(scene, threads[t]));
    bullet.push_back(run_bullet(scene));
  }
  fmt::print(
      "engine,scene,bodies,steps,repetitions,ms_step,ms_step_last_100,ms_step_p99,overlap_max_mm,overlap_mean_mm,"
      "overlapping_pairs,moved_m,joint_separation_max_mm,peak_memory_mb,pairs_percent,collide_percent,colors_percent,"
      "substeps_percent,rest_percent\n");
  for (std::size_t t = 0; t < threads.size(); ++t)
    print(fmt::format("lockstep ({} threads)", threads[t]), scene, ours[t], shares(scene, threads[t]));
  print("bullet (1 thread)", scene, bullet, ",,,,,");
} catch (const std::exception& error) {
  fmt::print(stderr, "peers_bench: {}\n", error.what());
  return 2;
}
