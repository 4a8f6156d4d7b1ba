// What a step of a large heap costs: cubes that fall into a box, at rest on each other after a while. Medians of steps
// on an OpenCL device, the host's part of them included.
//   heap_bench [--device auto] [--substeps 4] [--profile] [COUNT...]     cubes; default 4096 32768 102400
// With --profile the heap falls once more, and the table has what each stage of a step took, ms.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/median.hpp"
#include "host/backends/device_backend.hpp"
#include "host/error.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/exact_math.hpp"
#include "host/scene/solid_body.hpp"
#include "host/simulation.hpp"

namespace lockstep::bench {
namespace {

constexpr u32 settling = 180, measured = 60;  // steps
constexpr u32 most_layers = 25;
constexpr double spacing = 1.3;  // m, of cubes of 1 m

double clock_milliseconds() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void add_wall(BodyDescription& box, const Vector3& offset, const Vector3& normal) {
  ShapeDescription wall;
  wall.kind = SHAPE_PLANE;
  wall.offset = offset;
  wall.rotation = exact::rotation_from_z_to(normal);
  box.shapes.push_back(wall);
}

/// Tilted cubes of 1 kg in layers that are shifted against each other, about as many as `count`.
Scene heap(u32 count, u32 substeps) {
  const u32 layers = std::clamp(static_cast<u32>(std::cbrt(count)), 1u, most_layers);
  const u32 side = std::max(1u, static_cast<u32>(std::lround(std::sqrt(double(count) / layers))));
  const double half = 0.5 * spacing * side + 1;
  Scene scene;
  scene.source = scene.name = "heap";
  replace_solver(scene.settings, Solver::small_steps);
  scene.settings.substeps = substeps;
  scene.materials = {{.name = "wood", .friction = 0.5}};
  BodyDescription box;
  box.kind = BODY_STATIC;
  add_wall(box, {0, 0, 0}, {0, 0, 1});
  for (const double sign : {-1.0, 1.0}) {
    add_wall(box, {sign * half, 0, 0}, {-sign, 0, 0});
    add_wall(box, {0, sign * half, 0}, {0, -sign, 0});
  }
  scene.bodies.push_back(box);
  for (u32 layer = 0; layer < layers; ++layer) {
    exact::LcgByIndex shifts(layer + 1);
    const double shift_x = 0.4 * shifts.next_symmetric(), shift_y = 0.4 * shifts.next_symmetric();
    for (u32 index = 0; index < side * side; ++index) {
      BodyDescription cube;
      cube.position = {spacing * (index % side + 0.5 - 0.5 * side) + shift_x,
                       spacing * (index / side + 0.5 - 0.5 * side) + shift_y, 1 + spacing * layer};
      cube.orientation = exact::rotation_from_euler_degrees({8, 5, 10});
      cube.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {0.5, 0.5, 0.5}});
      make_solid_of_mass(cube, 1);
      scene.bodies.push_back(std::move(cube));
    }
  }
  return scene;
}

struct Timing {
  std::vector<double> milliseconds;  // of each step
  Counters counters;                 // of the last
  StageSeconds stages;               // of all steps, settling too; of a profile
};

Timing settle_and_measure(const InitialState<float>& state, const DeviceInfo& device, bool profile) {
  DeviceOptions options;
  options.profile = profile;
  auto owned = std::make_unique<DeviceBackend<float>>(state, device, options);
  const DeviceBackend<float>& backend = *owned;
  Simulation<float> simulation(std::move(owned), state.params);
  for (u32 i = 0; i < settling; ++i) simulation.step();
  const StageSeconds before = backend.stage_seconds();
  Timing timing;
  for (u32 i = 0; i < measured; ++i) {
    const double start = clock_milliseconds();
    simulation.step();
    timing.milliseconds.push_back(clock_milliseconds() - start);
  }
  timing.counters = simulation.counters();
  timing.stages = backend.stage_seconds();
  for (u32 s = 0; s < stage_count; ++s) timing.stages[s] -= before[s];
  return timing;
}

// "begin_step 0.01; update_bounds 0.02", ms a step.
std::string in_words(const StageSeconds& stages) {
  std::string words;
  for (u32 s = 0; s < stage_count; ++s)
    if (stages[s] > 0)
      words += fmt::format("{}{} {:.3f}", words.empty() ? "" : "; ", info(static_cast<Stage>(s)).name,
                           1e3 * stages[s] / measured);
  return words;
}

void measure(const DeviceInfo& device, u32 count, u32 substeps, bool profile) {
  const InitialState<float> state = compile<float>(heap(count, substeps));
  const Timing timing = settle_and_measure(state, device, false);
  const double ms = median(timing.milliseconds);
  const Counters& counters = timing.counters;
  const u32 bodies = state.sizes.bodies - 1;
  fmt::print("{},{},{},{},{},{},{:.4f},{:.2f},{}\n", device.name, bodies, counters[COUNTER_CONTACTS],
             counters[COUNTER_BLOCKS] * PACK, counters[COUNTER_COLORS], substeps, ms, 1e6 * ms / bodies,
             profile ? in_words(settle_and_measure(state, device, true).stages) : "");
  std::fflush(stdout);
}

}  // namespace
}  // namespace lockstep::bench

int main(int argc, char** argv) {
  using namespace lockstep;
  CLI::App program("What a step of a large heap of cubes costs");
  std::vector<u32> counts = {4096, 32768, 102400};
  std::string choice = "auto";
  u32 substeps = 4;
  bool profile = false;
  program.add_option("count", counts, "Cubes")->capture_default_str()->check(CLI::Range(1u, 10000000u));
  program.add_option("--device", choice, "As of lockstep run")->capture_default_str();
  program.add_option("--substeps", substeps, "Of a step")->capture_default_str()->check(CLI::Range(1u, 1000u));
  program.add_flag("--profile", profile, "And what each stage takes, of one more run");
  CLI11_PARSE(program, argc, argv);
  try {
    const auto device = select_device(choice);
    if (!device) throw Error(Failure::device, "heap_bench", "needs an OpenCL device");
    fmt::print("device,bodies,contacts,pairs_at_most,colors,substeps,ms_per_step,ns_per_body,stages_ms\n");
    for (const u32 count : counts) bench::measure(*device, count, substeps, profile);
  } catch (const Error& error) {
    fmt::print(stderr, "heap_bench: {}\n", error.what());
    return error.failure() == Failure::input ? 2 : 3;
  }
}
