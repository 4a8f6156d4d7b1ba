// An opened device: its context and the programs built for it, shared by everything in the process that runs on it.
#pragma once

#include <map>
#include <string>

#include "host/device/devices.hpp"
#include "host/device/opencl.hpp"
#include "host/device/program_cache.hpp"

namespace lockstep {

/// A built program, and whether the disk has it too.
struct BuiltProgram {
  cl::Program program;
  CacheKey key;
  bool on_disk = false;
};

struct Device {
  DeviceInfo info;
  cl::Device handle;  // a part of the device where `threads` limits it
  cl::Context context;
  u32 compute_units = 0;
  std::size_t max_work_group = 1;
  std::map<std::string, BuiltProgram> programs;  // by options and source
};

/// The device of list_devices(); `threads` limits a CPU device to that many compute units (0: all). The same object for
/// the same arguments, kept until the process ends.
Device& open_device(const DeviceInfo& info, u32 threads = 0);

/// The OpenCL handles in the order of list_devices().
const std::vector<cl::Device>& device_handles();

}  // namespace lockstep
