// The narrow phase alone on an OpenCL device: nanoseconds per candidate pair, from the list of pairs to the list of
// contacts, for each pair of kinds, beside the plain C++ reference on one thread.
//   narrow_phase_bench [PAIRS [KIND]]    pairs of each two kinds; default 40000; only those with a shape of this kind,
//                                        or only these two (box-hull)
// Shapes of a pair are of like size, turned at random, and so close that their bounds overlap: about half of them
// touch.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>

#include "host/backends/device_backend.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/error.hpp"
#include "host/scene/compile.hpp"

namespace lockstep::bench {
namespace {

constexpr const char* kind_names[] = {"sphere", "capsule", "box", "cylinder", "hull", "plane"};

/// The same numbers for the same seed.
class Random {
 public:
  explicit Random(u32 seed) : state_(seed) {}
  double between(double low, double high) {
    state_ += 0x9e3779b9u;
    u32 z = (state_ ^ (state_ >> 16)) * 0x85ebca6bu;
    z = (z ^ (z >> 13)) * 0xc2b2ae35u;
    return low + (high - low) * ((z ^ (z >> 16)) >> 8) / 16777216.0;
  }

 private:
  u32 state_;
};

ShapeDescription shape_of(u32 kind, Random& random) {
  ShapeDescription shape;
  shape.kind = static_cast<ShapeKind>(kind);
  const auto size = [&] { return random.between(0.4, 0.6); };
  shape.radius = size();
  shape.half_length = size();
  shape.half_extents = {size(), size(), size()};
  if (kind == SHAPE_HULL) {  // a truncated cube, the same for all: 24 corners
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5})
        for (const double z : {-0.5, 0.5})
          for (unsigned k = 0; k < 3; ++k) {
            Vector3 corner = {x, y, z};
            corner[k] *= 0.4;
            shape.points.push_back(corner);
          }
  }
  return shape;
}

/// Pairs on a lattice, far from each other.
Scene scene_of(u32 kind_a, u32 kind_b, u32 pairs) {
  Scene scene;
  scene.name = scene.source = "pairs";
  Random random(100 * kind_a + kind_b);
  const auto add = [&](u32 kind, BodyKind type, const Vector3& position) {
    BodyDescription body;
    body.kind = type;
    body.mass = type == BODY_DYNAMIC ? 1 : 0;
    body.inertia = {0.1, 0.1, 0.1};
    body.position = position;
    body.shapes = {shape_of(kind, random)};
    Quaternion q;
    for (double& x : q) x = random.between(-1, 1);
    if (kind != SHAPE_PLANE) body.orientation = exact::unit(q);
    scene.bodies.push_back(body);
  };
  for (u32 i = 0; i < pairs; ++i) {
    const Vector3 position = {5.0 * (i % 64), 5.0 * (i / 64 % 64), 5.0 * (i / 4096)};
    const Vector3 near = {random.between(-0.55, 0.55), random.between(-0.55, 0.55), random.between(-0.55, 0.55)};
    if (kind_b == SHAPE_PLANE) {
      add(kind_a, BODY_DYNAMIC, {5.0 * (i % 256), 5.0 * (i / 256), random.between(0.2, 0.8)});
    } else {
      add(kind_a, BODY_DYNAMIC, exact::add(position, {near[0], near[1], near[2]}));
      add(kind_b, BODY_DYNAMIC, exact::subtract(position, near));
    }
  }
  if (kind_b == SHAPE_PLANE) add(SHAPE_PLANE, BODY_STATIC, {0, 0, 0});
  return scene;
}

double clock_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<Stage> stages_of(Features features) {
  std::vector<Stage> stages = {Stage::begin_step, Stage::update_bounds};
  if (has(features, Feature::grid)) stages.insert(stages.end(), {Stage::sort_cells, Stage::find_pairs});
  if (has(features, Feature::all_pairs)) stages.push_back(Stage::compare_shapes);
  if (has(features, Feature::bvh))
    stages.insert(stages.end(), {Stage::sort_shapes, Stage::build_tree, Stage::search_tree});
  return stages;
}

struct Timing {
  double seconds = 1e9;
  u32 pairs = 0, contacts = 0;
};

template <class Run>
Timing best_of(int repetitions, Run&& run) {
  Timing best;
  for (int n = 0; n < repetitions; ++n) {
    const Timing timing = run();
    if (n > 0) best.seconds = std::min(best.seconds, timing.seconds);
    best.pairs = timing.pairs;
    best.contacts = timing.contacts;
  }
  return best;
}

Timing on_device(const InitialState<float>& state, const DeviceInfo& device, u32 threads) {
  DeviceOptions options;
  options.threads = threads;
  options.only = stages_of(state.features);
  options.only.push_back(Stage::collide);
  options.profile = true;
  DeviceBackend<float> backend(state, device, options);
  double before = 0;
  return best_of(9, [&] {
    for (const Stage stage : options.only) backend.run(stage, state.params);
    const Counters counters = backend.counters();  // sizes the launches of the next round, too
    const double all = backend.stage_seconds()[static_cast<u32>(Stage::collide)];
    const Timing timing = {all - before, counters[COUNTER_PAIRS], counters[COUNTER_CONTACTS]};
    before = all;
    if (counters[COUNTER_STATUS] != 0) throw Error(Failure::device, "narrow_phase_bench", "a list is too short");
    return timing;
  });
}

Timing in_cpp(const InitialState<float>& state) {
  ReferenceBackend<float> backend(state);
  for (const Stage stage : stages_of(state.features)) backend.run(stage, state.params);
  return best_of(4, [&] {
    const double start = clock_seconds();
    backend.run(Stage::collide, state.params);
    const Buffers<float>& b = backend.buffers();
    return Timing{clock_seconds() - start, b.counters[COUNTER_PAIRS], b.counters[COUNTER_CONTACTS]};
  });
}

}  // namespace
}  // namespace lockstep::bench

int main(int argc, char** argv) {
  using namespace lockstep;
  using namespace lockstep::bench;
  CLI::App program("The narrow phase alone on an OpenCL device: nanoseconds per candidate pair");
  std::string choice = "cpu";
  program.add_option("--device", choice, "cpu, gpu, or an index of `lockstep devices`; a GPU has no number of threads")
      ->capture_default_str();
  u32 pairs = 40000;
  std::string only;
  program.add_option("pairs", pairs, "pairs of each two kinds")
      ->capture_default_str()
      ->check(CLI::Range(1u, 10000000u));
  program.add_option("kind", only, "only those with a shape of this kind, or only these two (box-hull)");
  CLI11_PARSE(program, argc, argv);
  try {
    bool found = false;
    const auto device = select_device(choice);
    if (!device) throw Error(Failure::input, "--device", "must be an OpenCL device");
    fmt::print("kinds,pairs,contacts,device_1_thread_ns,device_2_threads_ns,cpp_1_thread_ns,cpp_over_device\n");
    for (u32 a = 0; a < SHAPE_PLANE; ++a) {
      for (u32 b = a; b < SHAPE_KINDS; ++b) {
        const std::string kinds = fmt::format("{}-{}", kind_names[a], kind_names[b]);
        if (!only.empty() && only != kind_names[a] && only != kind_names[b] && only != kinds) continue;
        found = true;
        InitialState<float> state = compile<float>(scene_of(a, b, pairs));
        state.sizes.pairs = state.params.pair_capacity = 2 * pairs + 64;
        state.sizes.contacts = state.params.contact_capacity = 8 * pairs + 64;
        resize(state.buffers, state.sizes, state.features);
        const Timing one = on_device(state, *device, 1), two = on_device(state, *device, 2), cpp = in_cpp(state);
        const double ns = 1e9 / one.pairs;
        fmt::print("{},{},{},{:.1f},{:.1f},{:.1f},{:.2f}\n", kinds, one.pairs, one.contacts, ns * one.seconds,
                   ns * two.seconds, ns * cpp.seconds, cpp.seconds / one.seconds);
        std::fflush(stdout);
      }
    }
    if (!found) throw Error(Failure::input, only, "is no kind of shape and no pair of kinds; try box or box-hull");
  } catch (const Error& error) {
    fmt::print(stderr, "narrow_phase_bench: {}\n", error.what());
    return error.failure() == Failure::input ? 2 : 3;
  }
}
