#include "host/device/background_build.hpp"

#include <chrono>
#include <utility>

#include "host/device/device.hpp"
#include "host/device/program_cache.hpp"
#include "kernels/team.h"

namespace lockstep {

namespace {

CacheKey key_of(const FusedBuild& build) {
  const DeviceInfo& device = build.device;
  return make_cache_key({"was built", build.text, build_options(device, build.options, build.text), device.name,
                         device.vendor, device.platform, device.driver_version});
}

// A step that was aborted before its sub-steps, of a scene in which nothing is.
void run_on_nothing(Device& device, const cl::Program& program, const FusedBuild& build) {
  cl::CommandQueue queue(device.context, device.handle);
  cl::Kernel kernel(program, build.fused.signature.name.c_str());
  const auto filled = [&](std::span<const u32> words) {
    cl::Buffer buffer(device.context, CL_MEM_READ_WRITE, words.size_bytes());
    queue.enqueueWriteBuffer(buffer, CL_TRUE, 0, words.size_bytes(), words.data());
    return buffer;
  };
  std::vector<u32> words(COUNTER_COUNT + TEAM_WORDS);
  words[COUNTER_STATUS] = STATUS_STALLED;
  const cl::Buffer counters = filled(words), zeros = filled(std::vector<u32>(0x10000));
  const cl::Buffer values = build.fused.values.empty() ? zeros : filled(build.fused.values);
  cl_uint index = 0;
  for (const KernelParameter& parameter : build.fused.signature.parameters) {
    if (parameter.kind == KernelParameter::Kind::params) {
      const std::vector<std::byte> params(build.options.double_precision ? sizeof(StepParams<double>)
                                                                         : sizeof(StepParams<float>));
      kernel.setArg(index++, params.size(), params.data());
    } else {
      kernel.setArg(index++, parameter.name == "counters"       ? counters
                             : parameter.name == "fused_values" ? values
                                                                : zeros);
    }
  }
  queue.enqueueNDRangeKernel(kernel, cl::NullRange, std::size_t{build.groups} * build.work_group, build.work_group);
  queue.finish();
}

bool make(const FusedBuild& build) {
  try {
    Device& device = open_device(build.device, build.threads);
    const cl::Program& program = build_program(device, build.text, build.options).program;
    opencl_guard(build.device.name, [&] { run_on_nothing(device, program, build); });
    ProgramCache::of_user().store(key_of(build), {});
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

bool BackgroundBuild::was_made(const FusedBuild& build) {
  return ProgramCache::of_user().load(key_of(build)).has_value();
}

BackgroundBuild::BackgroundBuild(FusedBuild build)
    : made_(std::async(std::launch::async, [build = std::move(build)] { return make(build); })) {}

bool BackgroundBuild::is_ready() {
  return made_.valid() && made_.wait_for(std::chrono::seconds(0)) == std::future_status::ready && made_.get();
}

}  // namespace lockstep
