// An opened device: its context and the programs built for it, shared by everything in the process that runs on it.
#pragma once

#include <map>
#include <mutex>
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
  cl::Device handle;  // a part of the device where `threads` limits it, or the one without threads
  cl::Context context;
  u32 compute_units = 0;
  std::size_t max_work_group = 1;
  std::map<std::string, BuiltProgram> programs;  // by options and source
};

/// Held by whoever opens devices or builds programs: worlds of several threads share them.
std::recursive_mutex& device_mutex();

/// The device of list_devices(); `threads` limits a CPU device to that many compute units (0: all). One of them is the
/// thread that waits for the commands where the driver can do so: no other one has to wake for each. The same object
/// for the same arguments, kept until the process ends.
Device& open_device(const DeviceInfo& info, u32 threads = 0);

/// What OpenCL knows a device by.
struct DeviceHandles {
  cl::Device device;
  cl::Device threadless;  // the same processor by a driver without threads of its own; null where there is none
};

std::string device_name(const cl::Device& device);

/// In the order of list_devices().
const std::vector<DeviceHandles>& device_handles();

}  // namespace lockstep
