// The contact solver alone: nanoseconds per solve of a contact on an OpenCL device, for each lane count, beside native
// vectorised C++ of the same solve (native_solve.hpp), both from the same packed problem in the same run.
//   solve_bench [--device cpu] [SIDE...]     bodies on a cubic lattice of SIDE^3, three contacts each; default 20 and
//   48
// On a GPU a lane a work-item; the native solves are those of as many threads as the table says.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <barrier>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <thread>

#include "bench/native_solve.hpp"
#include "cpu_reference/reference.hpp"
#include "host/backends/device_backend.hpp"
#include "host/error.hpp"
#include "host/scene/exact_math.hpp"

namespace lockstep::bench {
namespace {

constexpr u32 sweeps = 10, repetitions = 15;

/// Unit spheres of 1 kg on a lattice, each in contact with its three upper neighbours, in random motion.
InitialState<float> lattice(u32 side) {
  InitialState<float> state;
  state.features = with(static_cast<Features>(Feature::contacts), Feature::time_stepping);
  Buffers<float>& b = state.buffers;
  const u32 count = side * side * side;
  state.sizes = {.worlds = 1, .bodies = count, .shapes = count, .contacts = 3 * count};
  state.sizes.blocks = state.sizes.rows = state.sizes.contacts / PACK + MAX_COLORS;
  resize(b, state.sizes, state.features);
  b.world_ranges[0] = {0, count, 0, count, 0, 0, 0, 1};
  u32 contacts = 0;
  for (u32 i = 0; i < count; ++i) {
    exact::LcgByIndex random(i);
    b.body_infos[i] = {0, i, BODY_DYNAMIC, 1};
    b.shape_infos[i] = {i, i, SHAPE_SPHERE, 0, 1, 1, 1, 0};
    Motion<float>& motion = b.motions[i];
    for (float* x : {motion.v, motion.w}) std::generate_n(x, 3, [&] { return float(random.next_symmetric()); });
    motion.inverse_mass = 1;
    motion.inertia_xx = motion.inertia_yy = motion.inertia_zz = 2.5f;
    const u32 index[3] = {i % side, i / side % side, i / side / side}, stride[3] = {1, side, side * side};
    for (u32 axis = 0; axis < 3; ++axis) {
      if (index[axis] + 1 < side)
        b.contacts[contacts] = {i, i + stride[axis], 0, i, i + stride[axis], 0, contacts, 0}, ++contacts;
    }
  }
  b.counters[COUNTER_CONTACTS] = contacts;
  state.params.bodies = count;
  state.params.worlds = 1;
  state.params.block_capacity = state.params.row_capacity = state.sizes.blocks;
  state.params.iterations = sweeps;
  reference::run_stage(Stage::color_contacts, b, state.params);
  reference::run_stage(Stage::pack_contacts, b, state.params);
  for (u32 i = 0; i < contacts; ++i) {
    exact::LcgByIndex random(count + i);
    const Vector3 n = exact::unit(Vector3{random.next_symmetric(), random.next_symmetric(), random.next() + 0.1});
    const u32 lane = b.contact_slots[i] % PACK;
    ContactBlock<float>& block = b.contact_blocks[b.contact_slots[i] / PACK];
    float* const fields[3][3] = {{block.normal_x, block.arm_a_x, block.arm_b_x},
                                 {block.normal_y, block.arm_a_y, block.arm_b_y},
                                 {block.normal_z, block.arm_a_z, block.arm_b_z}};
    for (u32 k = 0; k < 3; ++k) {
      fields[k][0][lane] = fields[k][2][lane] = float(n[k]);
      fields[k][1][lane] = -float(n[k]);
    }
    block.bias[lane] = float(0.1 * random.next_symmetric());
    block.friction[lane] = 0.5f;
    block.w_nn[lane] = 2;
    block.w_11[lane] = block.w_22[lane] = 7;
  }
  return state;
}

double clock_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A copy that starts on a cache line, as device memory does.
template <class T>
class Aligned {
 public:
  explicit Aligned(const std::vector<T>& from)
      : data_(static_cast<T*>(::operator new(from.size() * sizeof(T), line))), size_(from.size()) {
    std::uninitialized_copy(from.begin(), from.end(), data_);
  }
  ~Aligned() { ::operator delete(data_, line); }
  Aligned(const Aligned&) = delete;
  Aligned& operator=(const Aligned&) = delete;
  T* data() { return data_; }
  std::vector<T> copy() const { return {data_, data_ + size_}; }

 private:
  static constexpr std::align_val_t line{64};
  T* data_;
  std::size_t size_;
};

struct NativeProblem {
  explicit NativeProblem(const Buffers<float>& b)
      : color_starts(b.color_starts),
        colors(b.counters[COUNTER_COLORS]),
        bodies(b.block_bodies),
        blocks(b.contact_blocks),
        impulses(b.impulse_blocks),
        motions(b.motions) {}
  std::vector<u32> color_starts;
  u32 colors;
  Aligned<BlockBodies> bodies;
  Aligned<ContactBlock<float>> blocks;
  Aligned<ImpulseBlock<float>> impulses;
  Aligned<Motion<float>> motions;
};

/// All sweeps natively; each thread takes its share of every colour.
void solve_natively(NativeProblem& p, u32 threads) {
  std::barrier<> colour_done(threads);
  const auto work = [&](u32 thread) {
    for (u32 sweep = 0; sweep < sweeps; ++sweep) {
      for (u32 color = 0; color < p.colors; ++color) {
        const u32 first = p.color_starts[color], count = p.color_starts[color + 1] - first;
        const u32 begin = first + count * thread / threads, end = first + count * (thread + 1) / threads;
        for (u32 block = begin; block < end; ++block)
          solve_contacts(p.bodies.data()[block], p.blocks.data()[block], p.impulses.data()[block], p.motions.data());
        if (threads > 1) colour_done.arrive_and_wait();
      }
    }
  };
  std::vector<std::jthread> helpers;
  for (u32 thread = 1; thread < threads; ++thread) helpers.emplace_back(work, thread);
  work(0);
}

struct Timed {
  double seconds = 1e9;
  std::vector<Motion<float>> after;  // the first repetition
};

void compare(u32 side, const DeviceInfo& device, u32 threads) {
  const InitialState<float> state = lattice(side);
  const double solves = double(sweeps) * state.buffers.counters[COUNTER_CONTACTS];
  const bool on_cpu = device.type == DeviceType::cpu;
  const std::vector<u32> lane_counts = on_cpu ? std::vector<u32>{1, 8, 16} : std::vector<u32>{1};
  std::vector<std::unique_ptr<DeviceBackend<float>>> backends;
  for (const u32 lanes : lane_counts) {
    DeviceOptions options;
    options.lanes = lanes;
    options.threads = on_cpu ? threads : 0;
    options.only = {Stage::solve_constraints};
    backends.push_back(std::make_unique<DeviceBackend<float>>(state, device, options));
    backends.back()->counters();  // the plan comes from the step before
  }

  // in turns, so that a disturbance of the machine meets all
  Timed native;
  NativeProblem problem(state.buffers);
  std::vector<Timed> kernels(lane_counts.size());
  for (u32 repetition = 0; repetition < repetitions; ++repetition) {
    double start = clock_seconds();
    solve_natively(problem, threads);
    native.seconds = std::min(native.seconds, clock_seconds() - start);
    if (repetition == 0) native.after = problem.motions.copy();
    for (std::size_t i = 0; i < backends.size(); ++i) {
      start = clock_seconds();
      backends[i]->run(Stage::solve_constraints, state.params);
      backends[i]->counters();
      kernels[i].seconds = std::min(kernels[i].seconds, clock_seconds() - start);
      if (repetition == 0) kernels[i].after = backends[i]->download(std::array{Buffer::motions}).motions;
    }
  }
  const double native_ns = native.seconds / solves * 1e9;
  fmt::print("{},{},native,{:.2f},1.00,\n", solves / sweeps, threads, native_ns);
  for (std::size_t i = 0; i < backends.size(); ++i) {
    const bool equal =
        std::memcmp(kernels[i].after.data(), native.after.data(), native.after.size() * sizeof(Motion<float>)) == 0;
    const double ns = kernels[i].seconds / solves * 1e9;
    fmt::print("{},{},OpenCL lanes {},{:.2f},{:.2f},{}\n", solves / sweeps, threads, lane_counts[i], ns, ns / native_ns,
               equal ? "equal" : "DIFFER");
  }
}

}  // namespace
}  // namespace lockstep::bench

int main(int argc, char** argv) try {
  using namespace lockstep;
  CLI::App program("The solves of the contact solver on an OpenCL device beside native C++: nanoseconds a contact");
  std::string choice = "cpu";
  program.add_option("--device", choice, "cpu, gpu, or an index of `lockstep devices`")->capture_default_str();
  std::vector<u32> sides = {20, 48};
  program.add_option("side", sides, "spheres along an edge of the cube")
      ->capture_default_str()
      ->check(CLI::Range(2u, 200u));
  CLI11_PARSE(program, argc, argv);
  const auto device = select_device(choice);
  if (!device) throw Error(Failure::input, "--device", "must be an OpenCL device");
  fmt::print("contacts,threads,visit,ns_per_contact,against_native,bits\n");
  for (const u32 side : sides) {
    for (u32 threads = 1; threads <= std::max(1u, std::thread::hardware_concurrency()); threads *= 2)
      bench::compare(side, *device, threads);
  }
} catch (const std::exception& error) {
  fmt::print(stderr, "solve_bench: {}\n", error.what());
  return 2;
}
