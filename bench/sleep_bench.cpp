// What a step costs with islands asleep against the same islands awake, in one run: medians, and their ratio.
//   sleep_bench [PILES...]     piles of eight boxes each; default 4 125 1250
// Phases: awake (they rest, and nobody may sleep), one_moves (all sleep but a kinematic ball that turns far away, so
// that steps are made whole), asleep (all sleep, and nothing moves). Scenes of both sorts of settings are stepped in
// turns.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>

#include "bench/median.hpp"
#include "host/backends/device_backend.hpp"
#include "host/error.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/solid_body.hpp"
#include "host/simulation.hpp"

namespace lockstep::bench {
namespace {

constexpr u32 settling = 90, measured = 60;  // steps

double clock_milliseconds() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

BodyDescription box_at(const Vector3& position) {
  BodyDescription box;
  box.position = position;
  box.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {0.25, 0.25, 0.25}});
  make_solid_of_mass(box, 1);
  return box;
}

Scene piles(u32 count, Solver solver, double after, bool one_moves) {
  Scene scene;
  scene.source = scene.name = "piles";
  replace_solver(scene.settings, solver);
  if (after > 0) scene.settings.sleeping = SleepSettings{.after = after};
  scene.materials = {{.name = "wood", .friction = 0.5}};
  BodyDescription floor;
  floor.kind = BODY_STATIC;
  floor.shapes.push_back({.kind = SHAPE_PLANE});
  scene.bodies.push_back(floor);
  u32 side = 1;
  while (side * side < count) ++side;
  for (u32 pile = 0; pile < count; ++pile) {
    const Vector3 at = {2.5 * (pile % side), 2.5 * (pile / side), 0};
    for (u32 k = 0; k < 8; ++k)
      scene.bodies.push_back(box_at({at[0] + 0.504 * (k % 2), at[1] + 0.504 * (k / 2 % 2), 0.25 + 0.5 * (k / 4)}));
  }
  if (one_moves) {
    BodyDescription ball;
    ball.kind = BODY_KINEMATIC;
    ball.position = {-10, 0, 5};
    ball.angular_velocity = {0, 0, 1};
    ball.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.25});
    scene.bodies.push_back(ball);
  }
  return scene;
}

struct Phase {
  const char* name;
  double after;  // s; 0: no sleeping
  bool one_moves;
};
constexpr Phase phases[] = {{"off", 0, true}, {"awake", 1e9, true}, {"one_moves", 0.5, true}, {"asleep", 0.5, false}};

void measure(const std::vector<DeviceInfo>& devices, u32 count, Solver solver) {
  for (const DeviceInfo& device : devices) {
    std::vector<Simulation<float>> simulations;
    std::vector<std::vector<double>> times(std::size(phases));
    for (const Phase& phase : phases) {
      const InitialState<float> state = compile<float>(piles(count, solver, phase.after, phase.one_moves));
      simulations.emplace_back(std::make_unique<DeviceBackend<float>>(state, device), state.params);
      for (u32 i = 0; i < settling; ++i) simulations.back().step();
    }
    for (u32 i = 0; i < measured; ++i) {
      for (std::size_t k = 0; k < std::size(phases); ++k) {
        const double start = clock_milliseconds();
        simulations[k].step();
        times[k].push_back(clock_milliseconds() - start);
      }
    }
    const double off = median(times[0]);
    for (std::size_t k = 0; k < std::size(phases); ++k) {
      const double ms = median(times[k]);
      const Counters& counters = simulations[k].counters();
      fmt::print("{},{},{},{},{},{},{:.6f},{:.2f}\n", device.name, name_of(solver), 8 * count, phases[k].name,
                 counters[COUNTER_ASLEEP], counters[COUNTER_CONTACTS], ms, off / ms);
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace lockstep::bench

int main(int argc, char** argv) {
  using namespace lockstep;
  CLI::App program("What a step costs with islands asleep");
  std::vector<u32> counts = {4, 125, 1250};
  std::string device = "auto";
  program.add_option("piles", counts, "Piles of eight boxes")->capture_default_str();
  program.add_option("--device", device, "As of lockstep run")->capture_default_str();
  CLI11_PARSE(program, argc, argv);
  try {
    const auto found = select_device(device);
    if (!found) throw Error(Failure::device, "sleep_bench", "needs an OpenCL device");
    fmt::print("device,solver,bodies,phase,asleep,contacts,ms_per_step,off_over_this\n");
    for (const u32 count : counts)
      for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) bench::measure({*found}, count, solver);
  } catch (const Error& error) {
    fmt::print(stderr, "sleep_bench: {}\n", error.what());
    return 1;
  }
}
