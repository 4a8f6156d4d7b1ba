// A program built in a thread of its own while the device is at work.
#pragma once

#include <future>
#include <string>
#include <vector>

#include "host/device/devices.hpp"
#include "host/device/fused_substeps.hpp"
#include "host/device/program.hpp"

namespace lockstep {

/// What a launch of all sub-steps is built from, and how it is launched.
struct FusedBuild {
  DeviceInfo device;
  u32 threads = 0;  // as open_device() takes them
  std::string text;
  ProgramOptions options;
  FusedSubsteps fused;
  u32 groups = 1, work_group = 1;
};

/// Builds the program, and runs its kernel once on nothing, for a driver builds a kernel only when it runs: pocl, which
/// keeps what it built on disk. From then on it is built at once, here and in later runs. A build that fails is no
/// reason to end: it is never ready.
class BackgroundBuild {
 public:
  /// Whether this or an earlier process has made this build.
  static bool was_made(const FusedBuild& build);

  explicit BackgroundBuild(FusedBuild build);

  /// Whether it has been made; asked once more after that it says no.
  bool is_ready();

 private:
  std::future<bool> made_;  // its destructor waits: a driver that still builds when the process ends may abort it
};

}  // namespace lockstep
