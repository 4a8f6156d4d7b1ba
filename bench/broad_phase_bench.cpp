// The broad phase alone on an OpenCL device: nanoseconds per body from bounds to the list of pairs, by the grid and by
// the tree, and the sort that the tree is built with.
//   broad_phase_bench [COUNT...]     bodies; default 10000 100000 1000000
//   broad_phase_bench ratio [COUNT]  grid against tree while the largest of the spheres grows; default 50000 bodies
//   broad_phase_bench surface        1000 spheres on grounds of up to 131072 triangles; nanoseconds per shape
// With --device gpu (or an index) on that instead of a CPU device, and 0 threads in the table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>
#include <thread>

#include "host/backends/device_backend.hpp"
#include "host/device/device_launcher.hpp"
#include "host/device/program.hpp"
#include "host/error.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/surface.hpp"

namespace lockstep::bench {
namespace {

constexpr double fill = 0.5;  // of space by spheres

/// Processor time of all threads: what is left of a measurement on a machine that others use too.
double processor_time() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

double clock_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The same numbers for the same seed, in [0, 1).
class Random {
 public:
  explicit Random(u32 seed) : state_(seed * 0x9e3779b9u + 0x7f4a7c15u) {}
  double next() {
    state_ += 0x9e3779b9u;
    u32 z = (state_ ^ (state_ >> 16)) * 0x85ebca6bu;
    z = (z ^ (z >> 13)) * 0xc2b2ae35u;
    return ((z ^ (z >> 16)) >> 8) / 16777216.0;
  }

 private:
  u32 state_;
};

/// Spheres of these radii at random places of a cube that they fill to the same part whatever their number. `sorted`:
/// numbered layer by layer, as a generator of a scene numbers them; otherwise at random.
InitialState<float> spheres(const std::vector<double>& radii, bool sorted, Feature search) {
  InitialState<float> state;
  state.features = with(with(static_cast<Features>(Feature::contacts), Feature::time_stepping), search);
  Buffers<float>& b = state.buffers;
  const u32 count = static_cast<u32>(radii.size());
  Sizes& sizes = state.sizes;
  sizes = {.worlds = 1, .bodies = count, .shapes = count, .material_pairs = 1, .contacts = PACK};
  sizes.pairs = 16 * count;
  sizes.blocks = MAX_COLORS + 1;
  sizes.buckets = 64;
  while (sizes.buckets < 2 * count) sizes.buckets *= 2;
  resize(b, sizes, state.features);
  double volume = 0;
  for (const double r : radii) volume += 4.18879 * r * r * r;
  const double side = std::cbrt(volume / fill);
  std::vector<Vec4<float>> positions(count);
  Random random(count);
  for (u32 i = 0; i < count; ++i) {
    for (float* x : {&positions[i].x, &positions[i].y, &positions[i].z}) *x = static_cast<float>(side * random.next());
  }
  if (sorted) {
    const auto layer = [](const Vec4<float>& p) { return std::array{std::floor(p.z), std::floor(p.y), p.x}; };
    std::ranges::sort(positions, [&](const auto& p, const auto& q) { return layer(p) < layer(q); });
  }
  b.world_ranges[0] = {0, count, 0, count, 0, 0, 0, 1};
  for (u32 i = 0; i < count; ++i) {
    b.body_infos[i] = {0, i, BODY_DYNAMIC, 1};
    b.positions[i] = positions[i];
    b.orientations[i] = {0, 0, 0, 1};
    for (float& v : b.motions[i].v) v = static_cast<float>(0.2 * random.next() - 0.1);
    b.shape_infos[i] = {i, i, SHAPE_SPHERE, 0, 1, 1, 1, 0};
    b.shapes[i].rotation[3] = 1;
    b.shapes[i].size[0] = b.shapes[i].bounding_radius = static_cast<float>(radii[i]);
  }
  StepParams<float>& p = state.params;
  p.dt = 1.0f / 60;
  p.margin = 0.005f;
  p.substeps = p.worlds = 1;
  p.bodies = p.shapes = count;
  p.buckets = sizes.buckets;
  p.pair_capacity = sizes.pairs;
  return state;
}

std::vector<double> equal_radii(u32 count) { return std::vector<double>(count, 0.5); }

/// From 0.1 to 1 in equal shares of the logarithm, and one in a thousand ten times as large.
std::vector<double> mixed_radii(u32 count) {
  std::vector<double> radii(count);
  Random random(7);
  for (u32 i = 0; i < count; ++i) {
    radii[i] = 0.1 * std::pow(10.0, random.next()) * (i % 1000 == 0 ? 10 : 1);
  }
  return radii;
}

/// A thousand spheres on a waved ground of squares of 0.5 m, `points` each way.
InitialState<float> on_surface(u32 points, Feature search) {
  Scene scene;
  scene.source = "surface";
  scene.settings.broad_phase = search == Feature::grid ? BroadPhase::grid : BroadPhase::bvh;
  std::vector<std::vector<double>> rows(points, std::vector<double>(points));
  for (u32 j = 0; j < points; ++j)
    for (u32 i = 0; i < points; ++i) rows[j][i] = 0.1 * ((i * i + 3 * j) % 5);
  std::string flaw;
  ShapeDescription ground;
  ground.kind = SHAPE_FACET;
  ground.surface = make_surface(height_field(rows, 0.5), flaw);
  scene.bodies.emplace_back();
  scene.bodies.back().kind = BODY_STATIC;
  scene.bodies.back().shapes = {ground};
  Random random(points);
  const double half = 0.25 * (points - 1);
  for (u32 i = 0; i < 1000; ++i) {
    BodyDescription ball;
    ball.mass = 1;
    ball.inertia = {0.016, 0.016, 0.016};
    ball.position = {half * (2 * random.next() - 1), half * (2 * random.next() - 1), 0.5};
    ball.shapes.emplace_back();
    ball.shapes.back().radius = 0.2;
    scene.bodies.push_back(std::move(ball));
  }
  return compile<float>(std::span<const Scene>(&scene, 1));
}

struct Timing {
  double seconds = 1e9, processor = 1e9;
  u32 pairs = 0;
  std::string stages;  // milliseconds of each, of a run that asks for them
};

Timing measure(const InitialState<float>& state, const DeviceInfo& device, u32 threads) {
  std::vector<Stage> stages = {Stage::begin_step, Stage::update_bounds};
  if (has(state.features, Feature::grid)) stages.insert(stages.end(), {Stage::sort_cells, Stage::find_pairs});
  if (has(state.features, Feature::bvh))
    stages.insert(stages.end(), {Stage::sort_shapes, Stage::build_tree, Stage::search_tree});
  DeviceOptions options;
  options.threads = threads;
  options.only = stages;
  const u32 repetitions = std::clamp(2000000 / state.sizes.bodies, 3u, 15u);
  Timing timing;
  for (const bool profile : {false, true}) {
    options.profile = profile;
    DeviceBackend<float> backend(state, device, options);
    const u32 runs = profile ? 1 : repetitions;
    for (u32 n = 0; n <= runs; ++n) {
      const double start = clock_seconds(), start_processor = processor_time();
      for (const Stage stage : stages) backend.run(stage, state.params);
      const Counters counters = backend.counters();
      if (counters[COUNTER_STATUS] != 0) throw Error(Failure::device, "broad_phase_bench", "a list is too short");
      timing.pairs = counters[COUNTER_PAIRS];
      if (profile || n == 0) continue;
      timing.seconds = std::min(timing.seconds, clock_seconds() - start);
      timing.processor = std::min(timing.processor, processor_time() - start_processor);
    }
    if (!profile) continue;
    const auto seconds = backend.stage_seconds();
    for (const Stage stage : std::span(stages).subspan(1))
      timing.stages += fmt::format("{}{} {:.2f}", timing.stages.empty() ? "" : "; ", info(stage).name,
                                   1e3 * seconds[static_cast<u32>(stage)] / (runs + 1));
  }
  return timing;
}

void print_row(const char* sizes, const char* order, Feature search, u32 shapes, u32 threads, const Timing& timing) {
  fmt::print("{},{},{},{},{},{:.1f},{:.1f},{},{}\n", sizes, order, search == Feature::grid ? "grid" : "tree", shapes,
             threads, 1e9 * timing.seconds / shapes, 1e9 * timing.processor / shapes, timing.pairs, timing.stages);
  std::fflush(stdout);
}

void report(const char* sizes, const char* order, Feature search, const std::vector<double>& radii,
            const DeviceInfo& device, u32 threads) {
  const Timing timing = measure(spheres(radii, std::strcmp(order, "layers") == 0, search), device, threads);
  print_row(sizes, order, search, static_cast<u32>(radii.size()), threads, timing);
}

/// 1, 2, 4, ... of a CPU device; a GPU takes no such number.
std::vector<u32> thread_counts(const DeviceInfo& device, u32 most) {
  if (device.type != DeviceType::cpu) return {0};
  std::vector<u32> counts;
  for (u32 threads = 1; threads <= std::max(1u, most); threads *= 2) counts.push_back(threads);
  return counts;
}

void bench_surface(const DeviceInfo& device) {
  for (const u32 points : {33u, 129u, 257u}) {
    for (const Feature search : {Feature::grid, Feature::bvh}) {
      const InitialState<float> state = on_surface(points, search);
      for (const u32 threads : thread_counts(device, 2))
        print_row("1000 spheres on triangles", "rows", search, state.sizes.shapes, threads,
                  measure(state, device, threads));
    }
  }
}

void bench_sort(const DeviceInfo& info, u32 threads) {
  Device& device = open_device(info, threads);
  cl::CommandQueue queue(device.context, device.handle);
  const KernelSources sources = KernelSources::embedded();
  const std::vector<std::string> files = {"radix_sort.cl", "scan.cl"};
  const auto signatures = sources.signatures(files);
  DeviceMemory memory(device, queue);
  memory.allocate(Buffer::counters, COUNTER_COUNT * sizeof(u32), 0);
  BuildClock builds{"", {}, 0};  // told to nobody
  DeviceLauncher launcher(device, queue, memory, builds, 0, false);
  const u32 lanes = info.type == DeviceType::cpu ? 16 : 1;
  launcher.add(build_program(device, sources.assemble(files), {.lanes = lanes}).program, signatures);
  launcher.plan().lanes = lanes;
  launcher.begin(Stage::begin_step, {});
  for (const u32 count : {1u << 16, 1u << 20, 1u << 22}) {
    std::vector<u32> keys(count), values(count);
    for (u32 i = 0; i < count; ++i) keys[i] = i * 2654435761u ^ (i >> 7) * 40503u;
    std::iota(values.begin(), values.end(), 0u);
    double seconds = 1e9, processor = 1e9;
    for (u32 n = 0; n < 8; ++n) {
      for (const char* name : {"keys", "values", "more_keys", "more_values"}) launcher.scratch(name, count);
      queue.enqueueWriteBuffer(memory.find("keys")->buffer, CL_TRUE, 0, count * sizeof(u32), keys.data());
      queue.enqueueWriteBuffer(memory.find("values")->buffer, CL_TRUE, 0, count * sizeof(u32), values.data());
      const double start = clock_seconds(), start_processor = processor_time();
      launcher.sort({"keys", "values", "more_keys", "more_values"}, count, 32);
      queue.finish();
      if (n == 0) continue;
      seconds = std::min(seconds, clock_seconds() - start);
      processor = std::min(processor, processor_time() - start_processor);
    }
    fmt::print("sort of 32 bits,random,radix,{},{},{:.2f},{:.2f},,{:.0f} million keys a second\n", count, threads,
               1e9 * seconds / count, 1e9 * processor / count, 1e-6 * count / seconds);
    std::fflush(stdout);
  }
}

void bench_ratio(const DeviceInfo& device, u32 count) {
  for (const double ratio : {1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 16.0}) {
    std::vector<double> radii(count, 0.5);
    for (u32 i = 0; i < count; i += 1000) radii[i] *= ratio;
    for (const Feature search : {Feature::grid, Feature::bvh})
      report(fmt::format("one in 1000 {} times as large", ratio).c_str(), "random", search, radii, device,
             thread_counts(device, 2).back());
  }
}

}  // namespace
}  // namespace lockstep::bench

int main(int argc, char** argv) try {
  using namespace lockstep;
  CLI::App program("The broad phase alone on an OpenCL device, and the sort: nanoseconds a body");
  std::string choice = "cpu";
  program.add_option("--device", choice, "cpu, gpu, or an index of `lockstep devices`")->capture_default_str();
  std::vector<u32> counts = {10000, 100000, 1000000};
  u32 spheres = 50000;
  program.add_option("count", counts, "bodies")->capture_default_str()->check(CLI::Range(2u, 100000000u));
  CLI::App* ratio = program.add_subcommand("ratio", "grid against tree while the largest of the spheres grows");
  ratio->add_option("count", spheres, "bodies")->capture_default_str()->check(CLI::Range(2u, 100000000u));
  CLI::App* surface = program.add_subcommand("surface", "1000 spheres on grounds of triangles");
  CLI11_PARSE(program, argc, argv);
  const auto device = select_device(choice);
  if (!device) throw Error(Failure::input, "--device", "must be an OpenCL device");
  fmt::print("sizes,order,search,bodies,threads,ns_per_body,processor_ns_per_body,pairs,stages_ms\n");
  if (*ratio) {
    bench::bench_ratio(*device, spheres);
    return 0;
  }
  if (*surface) {
    bench::bench_surface(*device);
    return 0;
  }
  for (const u32 threads : bench::thread_counts(*device, std::thread::hardware_concurrency())) {
    for (const u32 count : counts) {
      for (const char* order : {"layers", "random"}) {
        for (const Feature search : {Feature::grid, Feature::bvh})
          bench::report("equal", order, search, bench::equal_radii(count), *device, threads);
      }
      bench::report("mixed 1:100", "random", Feature::bvh, bench::mixed_radii(count), *device, threads);
    }
    bench::bench_sort(*device, threads);
  }
} catch (const std::exception& error) {
  fmt::print(stderr, "broad_phase_bench: {}\n", error.what());
  return 2;
}
