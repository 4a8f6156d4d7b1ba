// Layouts of the contacts' rows on a device: u = J v and v = M^-1 J^T lambda of the constraint system of a scene, in
// the layouts of bench/layouts.cl. Bytes, time and GB/s; what each layout computes is held against double, and csr and
// sell against each other bit by bit.
//
//   layouts_bench [--device cpu] [--threads N] [SCENE...] > bench/results/MACHINE/layouts.csv
//
// Times are medians of runs of all layouts in turn, each the mean of several launches. `matrix_bytes` is what the
// layout stores for a contact, `bytes` what a product moves at least: that, a line of 32 bytes for each velocity (16
// for an impulse) that a block reads, what is written between two kernels and read again, and the result. `other_bits`:
// by how many numbers the result differs from that of csr. `error`: the largest, in parts of the largest number.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <bit>
#include <chrono>
#include <functional>
#include <random>

#include "bench/layouts.hpp"
#include "bench/median.hpp"
#include "host/backends/device_backend.hpp"
#include "host/device/program.hpp"
#include "host/embedded.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace lockstep {
std::span<const EmbeddedFile> embedded_layouts();
}

namespace lockstep::bench {
namespace {

constexpr u32 repetitions = 21, launches = 8;
constexpr double line_bytes = 32, impulse_bytes = 16;
constexpr const char* where = "layouts_bench";

using Line = std::array<float, 8>;     // v, -, w, -
using Impulse = std::array<float, 4>;  // normal, tangent, tangent, -
using Result = std::vector<double>;    // 3 numbers a contact, or 6 a body

double clock_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class Kernels {
 public:
  Kernels(Device& device, u32 lanes) : device_(device), queue_(device.context, device.handle) {
    std::vector<KernelFile> files;
    for (const EmbeddedFile& file : embedded_kernels())
      files.push_back({std::string(file.name.substr(file.name.find('/') + 1)), std::string(file.text)});
    const EmbeddedFile& own = embedded_layouts().front();
    files.push_back({std::string(own.name), std::string(own.text)});
    const std::string names[] = {std::string(own.name)};
    ProgramOptions options;
    options.lanes = lanes;
    program_ = build_program(device, KernelSources(std::move(files)).assemble(names), options).program;
    group_ = std::min<std::size_t>(device.max_work_group, lanes > 1 ? 16 : 64);
  }

  template <class T>
  cl::Buffer copy(const std::vector<T>& from) const {
    cl::Buffer buffer(device_.context, CL_MEM_READ_WRITE, std::max<std::size_t>(from.size(), 1) * sizeof(T));
    if (!from.empty()) write(buffer, from);
    return buffer;
  }
  template <class T>
  void write(const cl::Buffer& to, const std::vector<T>& from) const {
    queue_.enqueueWriteBuffer(to, CL_TRUE, 0, from.size() * sizeof(T), from.data());
  }
  template <class T>
  std::vector<T> read(const cl::Buffer& from, std::size_t count) const {
    std::vector<T> result(count);
    if (count > 0) queue_.enqueueReadBuffer(from, CL_TRUE, 0, count * sizeof(T), result.data());
    return result;
  }

  /// A launch over so many work-items.
  template <class... Arguments>
  std::function<void()> launch(const char* name, std::size_t items, const Arguments&... arguments) const {
    cl::Kernel kernel(program_, name);
    cl_uint index = 0;
    (kernel.setArg(index++, arguments), ...);
    const std::size_t grid = (items + group_ - 1) / group_ * group_;
    // kernels do not keep their buffers alive
    return [=, this, kept = std::make_tuple(arguments...)] {
      queue_.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(grid), cl::NDRange(group_));
    };
  }
  void finish() const { queue_.finish(); }

 private:
  Device& device_;
  cl::CommandQueue queue_;
  cl::Program program_;
  std::size_t group_ = 1;
};

/// A product in one layout.
struct Product {
  std::string layout;
  double matrix_bytes, bytes;  // a contact
  std::function<void()> run;
  std::function<Result()> result;
  std::vector<double> seconds = {};
};

class Comparison {
 public:
  Comparison(const Kernels& kernels, const LayoutProblem& problem, u32 lanes)
      : kernels_(kernels), problem_(problem), items_(PACK / lanes), null_(u32(problem.bodies.size())) {
    std::mt19937 random(1);
    const auto number = [&] { return float(random()) / 2147483648.0f - 1; };
    velocities_.resize(problem.bodies.size() + 1, Line{});
    for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
      for (const int k : {0, 1, 2, 4, 5, 6}) velocities_[i][std::size_t(k)] = number();
    }
    impulses_.resize(problem.contacts.size() + 1, Impulse{});
    for (std::size_t i = 0; i < problem.contacts.size(); ++i) impulses_[i] = {number(), number(), number(), 0};
    packed_ = packed_rows(problem, null_);
  }

  std::vector<Product> times() const {
    const BlockMatrix j = jacobian_of(problem_);
    std::vector<Product> products;
    const cl::Buffer v = kernels_.copy(velocities_);
    const double count = double(problem_.contacts.size());
    {
      const cl::Buffer starts = kernels_.copy(j.starts), columns = kernels_.copy(j.columns);
      const cl::Buffer values = kernels_.copy(j.values);
      const cl::Buffer u = kernels_.copy(std::vector<float>(3 * problem_.contacts.size(), -1));
      const double bytes = stored(j.starts, j.columns, j.values);
      products.push_back({"csr", bytes / count, (bytes + line_bytes * j.blocks()) / count + 12,
                          kernels_.launch("csr_times", j.rows(), starts, columns, values, v, u, j.rows()), [=, this] {
                            const auto got = kernels_.read<float>(u, 3 * problem_.contacts.size());
                            return Result(got.begin(), got.end());
                          }});
    }
    for (const u32 sigma : {1u, 256u}) {
      const SlicedMatrix s = sliced(j, sigma, null_);
      const cl::Buffer starts = kernels_.copy(s.starts), columns = kernels_.copy(s.columns);
      const cl::Buffer values = kernels_.copy(s.values), u = kernels_.copy(std::vector<float>(3 * s.order.size(), -1));
      const double bytes = stored(s.starts, s.columns, s.values);
      products.push_back({fmt::format("sell-{}-{}", PACK, sigma), bytes / count,
                          (bytes + line_bytes * double(s.columns.size())) / count + 12,
                          kernels_.launch("sell_times", s.chunks() * items_, starts, columns, values, v, u, s.chunks()),
                          [=, this, order = s.order] { return in_rows(u, order); }});
    }
    const cl::Buffer blocks = kernels_.copy(packed_.blocks);
    const cl::Buffer u = kernels_.copy(std::vector<float>(3 * PACK * packed_.blocks.size(), -1));
    const u32 block_count = u32(packed_.blocks.size());
    const double bytes = double(block_count * sizeof(PackedBlock));
    products.push_back({"packed", bytes / count, bytes / count + 2 * line_bytes + 12,
                        kernels_.launch("packed_times", block_count * items_, blocks, v, u, block_count), [=, this] {
                          std::vector<u32> order(PACK * block_count, NONE);
                          for (u32 i = 0; i < problem_.contacts.size(); ++i) order[i] = i;
                          return in_rows(u, order);
                        }});
    return products;
  }

  std::vector<Product> gathers() const {
    const BlockMatrix b = mobility_of(problem_);
    std::vector<Product> products;
    const cl::Buffer impulses = kernels_.copy(impulses_);
    const double count = double(problem_.contacts.size()), lines = line_bytes * b.rows();
    {
      const cl::Buffer starts = kernels_.copy(b.starts), columns = kernels_.copy(b.columns);
      const cl::Buffer values = kernels_.copy(b.values), v = empty_lines(b.rows());
      const double bytes = stored(b.starts, b.columns, b.values);
      products.push_back({"csr", bytes / count, (bytes + impulse_bytes * b.blocks() + lines) / count,
                          kernels_.launch("csr_gather", b.rows(), starts, columns, values, impulses, v, b.rows()),
                          [=, this] { return in_lines(v); }});
    }
    for (const u32 sigma : {1u, 256u}) {
      const SlicedMatrix s = sliced(b, sigma, u32(problem_.contacts.size()));
      const cl::Buffer starts = kernels_.copy(s.starts), columns = kernels_.copy(s.columns);
      const cl::Buffer values = kernels_.copy(s.values), order = kernels_.copy(s.order), v = empty_lines(b.rows());
      const double bytes = stored(s.starts, s.columns, s.values) + 4.0 * double(s.order.size());
      products.push_back({fmt::format("sell-{}-{}", PACK, sigma), bytes / count,
                          (bytes + impulse_bytes * double(s.columns.size()) + lines) / count,
                          kernels_.launch("sell_gather", s.chunks() * items_, starts, columns, values, impulses, order,
                                          v, s.chunks(), b.rows()),
                          [=, this] { return in_lines(v); }});
    }
    const u32 block_count = u32(packed_.blocks.size()), slot_count = packed_.starts.back();
    std::vector<float> in_blocks(3 * PACK * packed_.blocks.size(), 0);
    for (std::size_t i = 0; i < problem_.contacts.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) in_blocks[i / PACK * 3 * PACK + k * PACK + i % PACK] = impulses_[i][k];
    }
    const cl::Buffer blocks = kernels_.copy(packed_.blocks), slots = kernels_.copy(packed_.slots);
    const cl::Buffer starts = kernels_.copy(packed_.starts), inverses = kernels_.copy(packed_.inverses);
    const cl::Buffer own_impulses = kernels_.copy(in_blocks), pushes = empty_lines(slot_count),
                     v = empty_lines(b.rows());
    const double bytes =
        double(block_count * sizeof(PackedBlock)) + stored(packed_.slots, packed_.starts, packed_.inverses);
    const auto push = kernels_.launch("packed_push", block_count * items_, blocks, own_impulses, slots, pushes,
                                      block_count, slot_count);
    const auto gather = kernels_.launch("packed_gather", b.rows(), starts, pushes, inverses, v, b.rows());
    products.push_back({"packed", bytes / count, (bytes + 2 * line_bytes * slot_count + lines) / count + 12,
                        [=] {
                          push();
                          gather();
                        },
                        [=, this] { return in_lines(v); }});
    products.push_back(coloured(count));
    return products;
  }

  /// The same products in double.
  Result exact_times() const {
    Result u;
    for (const LayoutProblem::Contact& c : problem_.contacts) {
      const auto at = [&](u32 body, const Eigen::Vector3d& arm) {
        if (body == NONE) return Eigen::Vector3d(Eigen::Vector3d::Zero());
        const Line& l = velocities_[body];
        return Eigen::Vector3d(Eigen::Vector3d(l[0], l[1], l[2]) + Eigen::Vector3d(l[4], l[5], l[6]).cross(arm));
      };
      const Eigen::Vector3d relative = at(c.body_a, c.arm_a) - at(c.body_b, c.arm_b);
      const Eigen::Vector2d tangential = solver_tangents(c.normal).transpose() * relative;
      u.insert(u.end(), {c.normal.dot(relative), tangential[0], tangential[1]});
    }
    return u;
  }
  Result exact_gather() const {
    std::vector<Eigen::Vector3d> impulse(problem_.bodies.size(), Eigen::Vector3d::Zero()), moment = impulse;
    for (std::size_t i = 0; i < problem_.contacts.size(); ++i) {
      const LayoutProblem::Contact& c = problem_.contacts[i];
      const Impulse& r = impulses_[i];
      const Eigen::Vector3d p = double(r[0]) * c.normal + solver_tangents(c.normal) * Eigen::Vector2d(r[1], r[2]);
      if (c.body_a != NONE) impulse[c.body_a] += p, moment[c.body_a] += c.arm_a.cross(p);
      if (c.body_b != NONE) impulse[c.body_b] -= p, moment[c.body_b] -= c.arm_b.cross(p);
    }
    Result v;
    for (std::size_t i = 0; i < problem_.bodies.size(); ++i) {
      const Eigen::Vector3d linear = problem_.bodies[i].inverse_mass * impulse[i];
      const Eigen::Vector3d angular = problem_.bodies[i].inverse_inertia * moment[i];
      v.insert(v.end(), {linear[0], linear[1], linear[2], angular[0], angular[1], angular[2]});
    }
    return v;
  }

 private:
  template <class... Vectors>
  static double stored(const Vectors&... vectors) {
    return (double(vectors.size() * sizeof(vectors[0])) + ...);
  }
  // Pushes bodies in place, so that velocities add up from run to run.
  Product coloured(double count) const {
    const ColouredRows rows = coloured_rows(problem_, null_);
    std::vector<float> in_blocks(3 * rows.contacts.size(), 0);
    for (std::size_t i = 0; i < rows.contacts.size(); ++i) {
      for (std::size_t k = 0; k < 3 && rows.contacts[i] != NONE; ++k)
        in_blocks[i / PACK * 3 * PACK + k * PACK + i % PACK] = impulses_[rows.contacts[i]][k];
    }
    const cl::Buffer starts = kernels_.copy(rows.starts), blocks = kernels_.copy(rows.blocks);
    const cl::Buffer impulses = kernels_.copy(in_blocks), motions = kernels_.copy(rows.motions);
    std::vector<std::function<void()>> pushes;
    for (std::size_t colour = 0; colour + 1 < rows.colours.size(); ++colour) {
      const u32 begin = rows.colours[colour], size = rows.colours[colour + 1] - begin;
      pushes.push_back(kernels_.launch("colour_push", size * items_, starts, blocks, impulses, motions, begin, size));
    }
    const auto run = [=] {
      for (const auto& push : pushes) push();
    };
    const double matrix = stored(rows.starts, rows.blocks), groups = double(rows.starts.size() - 1);
    // of each pair and body a record of two lines is read and one of them written
    const double lines = 2 * PACK * groups * 3 * line_bytes;
    return {"colours", matrix / count, (matrix + stored(in_blocks) + lines) / count, run,
            [=, this, at_rest = rows.motions] {
              kernels_.write(motions, at_rest);
              run();
              Result result;
              for (const Motion<float>& m : kernels_.read<Motion<float>>(motions, problem_.bodies.size()))
                result.insert(result.end(), {m.v[0], m.v[1], m.v[2], m.w[0], m.w[1], m.w[2]});
              return result;
            }};
  }

  cl::Buffer empty_lines(std::size_t count) const { return kernels_.copy(std::vector<Line>(count, Line{})); }

  Result in_rows(const cl::Buffer& u, const std::vector<u32>& order) const {
    const auto got = kernels_.read<float>(u, 3 * order.size());
    Result result(3 * problem_.contacts.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (order[i] == NONE) continue;
      for (std::size_t k = 0; k < 3; ++k) result[3 * order[i] + k] = got[i / PACK * 3 * PACK + k * PACK + i % PACK];
    }
    return result;
  }
  Result in_lines(const cl::Buffer& v) const {
    Result result;
    for (const Line& l : kernels_.read<Line>(v, problem_.bodies.size()))
      result.insert(result.end(), {l[0], l[1], l[2], l[4], l[5], l[6]});
    return result;
  }

  const Kernels& kernels_;
  const LayoutProblem& problem_;
  const u32 items_, null_;  // work-items a chunk; the body, behind the others, of what does not move
  std::vector<Line> velocities_;
  std::vector<Impulse> impulses_;
  PackedRows packed_;
};

ContactSystem system_of(const std::string& name, const DeviceInfo& device, u32 steps) {
  const Scene scene = read_scene(name);
  const InitialState<float> state = compile<float>(scene);
  Simulation<float> simulation(std::make_unique<DeviceBackend<float>>(state, device), state.params);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  Backend<float>& backend = simulation.backend();
  ContactSystem system = contact_system(backend.download(measured_buffers(backend.features())), simulation.counters());
  if (system.contacts.empty())
    throw Error(Failure::input, name, fmt::format("has no contacts after {} steps; take another scene", steps));
  return system;
}

void print(const std::string& head, const std::string& product, std::vector<Product>& products, const Result& exact,
           double contacts, const Kernels& kernels) {
  for (Product& p : products) p.run();  // builds what is specialised by size
  kernels.finish();
  for (u32 repetition = 0; repetition < repetitions; ++repetition) {
    for (Product& p : products) {
      const double start = clock_seconds();
      for (u32 i = 0; i < launches; ++i) p.run();
      kernels.finish();
      p.seconds.push_back((clock_seconds() - start) / launches);
    }
  }
  double largest = 0;
  for (const double x : exact) largest = std::max(largest, std::abs(x));
  const Result csr = products[0].result();
  for (Product& p : products) {
    const Result got = p.result();
    double off = 0;
    u32 other = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      off = std::max(off, std::abs(got[i] - exact[i]));
      other += std::bit_cast<u32>(float(got[i])) != std::bit_cast<u32>(float(csr[i])) ? 1 : 0;
    }
    const double ns = 1e9 * median(p.seconds) / contacts, of_csr = median(p.seconds) / median(products[0].seconds);
    fmt::print("{},{},{},{:.1f},{:.1f},{:.2f},{:.3f},{:.1f},{:.1e},{}\n", head, product, p.layout, p.matrix_bytes,
               p.bytes, ns, of_csr, p.bytes / ns, off / largest, other);
    if (off > 1e-5 * largest || (p.layout.starts_with("sell") && other > 0))
      throw Error(Failure::comparison, where, fmt::format("{} by {} is another result", product, p.layout));
  }
}

}  // namespace
}  // namespace lockstep::bench

int main(int argc, char** argv) try {
  using namespace lockstep;
  CLI::App program("Layouts of the contacts' rows on a device: bytes and time of J v and M^-1 J^T lambda");
  std::vector<std::string> scenes = {"box_heap", "wall", "spheres8000"};
  std::string choice = "cpu";
  u32 threads = 0, steps = 60, least = 300'000;
  program.add_option("scenes", scenes, "built-in scenes with contacts")->capture_default_str();
  program.add_option("--device", choice, "cpu, gpu or an index of `lockstep devices`")->capture_default_str();
  program.add_option("--threads", threads, "of a CPU device; 0: all");
  program.add_option("--steps", steps, "before the system is taken")->capture_default_str();
  program.add_option("--contacts", least, "each scene also in as many worlds as have that many")->capture_default_str();
  CLI11_PARSE(program, argc, argv);
  const auto info = select_device(choice);
  if (!info) throw Error(Failure::device, bench::where, "needs an OpenCL device (Debian: pocl-opencl-icd)");
  opencl_guard(bench::where, [&] {
    Device& device = open_device(*info, threads);
    fmt::print(
        "scene,worlds,bodies,contacts,device,threads,lanes,product,layout,matrix_bytes,bytes,ns_per_contact,"
        "of_csr,gb_per_s,error,other_bits\n");
    for (const std::string& scene : scenes) {
      const ContactSystem system = bench::system_of(scene, *info, steps);
      for (const u32 lanes : {1u, 16u}) {
        if (lanes > 1 && info->type != DeviceType::cpu) continue;
        const bench::Kernels kernels(device, lanes);
        for (const u32 worlds : {1u, u32(least / system.contacts.size()) + 1}) {
          const bench::LayoutProblem problem = bench::layout_problem(system, worlds);
          const bench::Comparison comparison(kernels, problem, lanes);
          const double contacts = double(problem.contacts.size());
          const std::string head = fmt::format("{},{},{},{},{},{},{}", scene, worlds, problem.bodies.size(), contacts,
                                               info->name, device.compute_units, lanes);
          auto times = comparison.times();
          bench::print(head, "J v", times, comparison.exact_times(), contacts, kernels);
          auto gathers = comparison.gathers();
          bench::print(head, "M^-1 J^T lambda", gathers, comparison.exact_gather(), contacts, kernels);
        }
      }
    }
  });
  return 0;
} catch (const lockstep::Error& error) {
  fmt::print(stderr, "{}\n", error.what());
  return static_cast<int>(error.failure());
}
