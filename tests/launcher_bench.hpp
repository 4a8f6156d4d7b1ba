// A device with some kernel files and a launcher, as DeviceBackend puts them together, without a scene.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "host/device/device_launcher.hpp"
#include "host/device/program.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::test {

struct LauncherBench {
  LauncherBench(KernelSources kernels, const std::string& file, u32 work_group = 0, bool profile = false, u32 lanes = 1)
      : LauncherBench(std::move(kernels), std::vector<std::string>{file}, work_group, profile, lanes) {}
  LauncherBench(KernelSources kernels, std::vector<std::string> files, u32 work_group = 0, bool profile = false,
                u32 lanes = 1)
      : device(open_device(test_device())),
        queue(device.context, device.handle, profile ? CL_QUEUE_PROFILING_ENABLE : 0),
        sources(std::move(kernels)),
        names(std::move(files)),
        signatures(sources.signatures(names)),
        memory(device, queue),
        launcher(device, queue, memory, builds, work_group, profile) {
    launcher.plan().lanes = lanes;
    launcher.add(build_program(device, sources.assemble(names), {.lanes = lanes}).program, signatures);
    memory.allocate(Buffer::counters, COUNTER_COUNT * sizeof(u32), 0);
    launcher.begin(Stage::begin_step, {});
  }

  /// Makes a scratch array that holds these words.
  void write(std::string_view array, const std::vector<u32>& words) {
    launcher.scratch(array, std::max<std::size_t>(words.size(), 1));
    if (!words.empty())
      queue.enqueueWriteBuffer(memory.find(array)->buffer, CL_TRUE, 0, words.size() * sizeof(u32), words.data());
  }

  /// The first words of an array or a buffer.
  std::vector<u32> read(std::string_view array, std::size_t count) {
    std::vector<u32> words(count);
    if (count > 0) queue.enqueueReadBuffer(memory.find(array)->buffer, CL_TRUE, 0, count * sizeof(u32), words.data());
    return words;
  }

  Device& device;
  cl::CommandQueue queue;
  KernelSources sources;
  std::vector<std::string> names;
  std::vector<KernelSignature> signatures;
  DeviceMemory memory;
  BuildClock builds{"", {}, 0};  // told to nobody
  DeviceLauncher launcher;
};

}  // namespace lockstep::test
