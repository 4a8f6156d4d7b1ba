#include "host/backends/canary.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <vector>

#include "cpu_reference/canary.hpp"
#include "host/backends/words.hpp"
#include "host/device/program.hpp"
#include "host/error.hpp"
#include "kernels/canary.h"

namespace lockstep {

namespace {

// Enough work-groups for every worker thread and compute unit to get some.
constexpr u32 sets_per_unit = 512, fewest_sets = 4096, most_sets = 65536;

struct Case {
  bool CanaryVerdict::*verdict;
  const char* formula;
};
constexpr Case cases[CANARY_CASES] = {
    {&CanaryVerdict::contraction_ok, "a * b + c"},
    {&CanaryVerdict::contraction_ok, "c - a * b"},
    {&CanaryVerdict::contraction_ok, "a * b - c * d"},
    {&CanaryVerdict::contraction_ok, "p = e * f; p + d"},
    {&CanaryVerdict::contraction_ok, "a * d + b * e + c * f"},
    {&CanaryVerdict::contraction_ok, "t = f; t += a * c; t -= b * d"},
    {&CanaryVerdict::contraction_ok, "product(c, e) + f"},
    {&CanaryVerdict::division_ok, "p / q"},
    {&CanaryVerdict::division_ok, "1 / q"},
    {&CanaryVerdict::sqrt_ok, "sqrt(p)"},
    {&CanaryVerdict::sqrt_ok, "1 / sqrt(q)"},
    {&CanaryVerdict::denormals_ok, "denormal + denormal"},
    {&CanaryVerdict::denormals_ok, "denormal * 65536"},
    {&CanaryVerdict::denormals_ok, "tiny * a"},
    {&CanaryVerdict::denormals_ok, "denormal / 3"},
    {&CanaryVerdict::denormals_ok, "sqrt(denormal)"},
    {&CanaryVerdict::division_ok, "p / 3"},
    {&CanaryVerdict::algebra_ok, "a * 0"},
    {&CanaryVerdict::algebra_ok, "zero + 0"},
    {&CanaryVerdict::algebra_ok, "0 - zero"},
    {&CanaryVerdict::algebra_ok, "zero > other ? zero : other"},
    {&CanaryVerdict::algebra_ok, "-(zero - other)"},
    {&CanaryVerdict::algebra_ok, "(a + b) - a"},
    {&CanaryVerdict::algebra_ok, "a + (b + c)"},
    {&CanaryVerdict::algebra_ok, "a * b + a * c"},
    {&CanaryVerdict::algebra_ok, "a * 3 * 5"},
    {&CanaryVerdict::algebra_ok, "p / q * q"},
    {&CanaryVerdict::algebra_ok, "sqrt(p) * sqrt(p)"},
    {&CanaryVerdict::algebra_ok, "(a - c) - (b - c)"},
    {&CanaryVerdict::algebra_ok, "a sum in a loop"},
};

template <class real>
std::vector<real> device_results(Device& device, u32 count, u32 lanes, std::span<const KernelPatch> patches) {
  const KernelSources sources = KernelSources::embedded(patches);
  const std::string files[] = {"canary.cl"};
  BuiltProgram& built = build_program(device, sources.assemble(files), {0, sizeof(real) == 8, lanes});
  return opencl_guard("the canary on " + device.info.name, [&] {
    std::vector<real> results(std::size_t{count} * CANARY_CASES);
    const std::size_t bytes = results.size() * sizeof(real);
    const cl::CommandQueue queue(device.context, device.handle);
    const cl::Buffer buffer(device.context, CL_MEM_READ_WRITE, bytes);
    const auto launch = [&](const char* name, std::size_t items, std::size_t work_group) {
      cl::Kernel kernel(built.program, name);
      kernel.setArg(0, buffer);
      kernel.setArg(1, count);
      queue.enqueueNDRangeKernel(kernel, cl::NullRange, items, work_group);
    };
    launch("canary", count / lanes, 16);
    launch("canary_sums", count, 1);  // where work-items make no vector, a compiler may make one of the loop
    queue.enqueueReadBuffer(buffer, CL_TRUE, 0, bytes, results.data());
    save_program(device, built);
    return results;
  });
}

template <class real>
CanaryVerdict judge(Device& device, u32 lanes, std::span<const KernelPatch> patches) {
  CanaryVerdict verdict;
  verdict.host_ok = reference::host_arithmetic_is_default();
  if (!verdict.host_ok) verdict.first_failure = "this thread does not round to nearest, or flushes denormals to zero";
  const u32 count = std::clamp(device.compute_units * sets_per_unit, fewest_sets, most_sets) / 256 * 256;
  const std::vector<real> ours = device_results<real>(device, count, lanes, patches);
  const std::vector<real> theirs = reference::canary<real>(count);
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    if (same_bits(ours[i], theirs[i])) continue;
    const Case& failed = cases[i / count];
    verdict.*failed.verdict = false;
    if (verdict.first_failure.empty())
      verdict.first_failure = std::string(failed.formula) + " of operand set " + std::to_string(i % count) +
                              ": device " + show_word(ours[i]) + ", reference " + show_word(theirs[i]);
  }
  return verdict;
}

}  // namespace

std::string describe(const CanaryVerdict& verdict) {
  if (verdict.bit_exact()) return "bit-exact";
  std::string text = "not bit-exact:";
  if (!verdict.host_ok) text += " host arithmetic,";
  if (!verdict.contraction_ok) text += " contraction,";
  if (!verdict.division_ok) text += " division,";
  if (!verdict.sqrt_ok) text += " square root,";
  if (!verdict.denormals_ok) text += " denormals,";
  if (!verdict.algebra_ok) text += " algebra,";
  text.back() = ';';
  return text + " " + verdict.first_failure;
}

CanaryVerdict run_canary(const DeviceInfo& info, bool double_precision, u32 lanes, u32 threads,
                         std::span<const KernelPatch> patches) {
  static std::map<std::tuple<u32, bool, u32, u32>, CanaryVerdict> known;
  const std::tuple key = {info.index, double_precision, lanes, threads};
  if (const auto found = known.find(key); patches.empty() && found != known.end()) return found->second;
  Device& device = open_device(info, threads);
  const CanaryVerdict verdict =
      double_precision ? judge<double>(device, lanes, patches) : judge<float>(device, lanes, patches);
  if (patches.empty()) known[key] = verdict;
  return verdict;
}

std::string verdict_in_words(const DeviceInfo& device, bool double_precision) {
  try {
    for (const u32 lanes : {1u, 8u, 16u}) {
      const CanaryVerdict verdict = run_canary(device, double_precision, lanes);
      if (!verdict.bit_exact()) return describe(verdict) + " (lanes " + std::to_string(lanes) + ")";
    }
    return "bit-exact";
  } catch (const Error& error) {
    return std::string("cannot run the canary: ") + error.what();
  }
}

}  // namespace lockstep
