// What OpenCL offers on this machine, and the choice of a device by a word of the command line.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/types.h"

namespace lockstep {

enum class DeviceType { cpu, gpu, other };

struct DeviceInfo {
  u32 index = 0;  // platforms in the loader's order, each with its devices in its own
  std::string name, vendor, platform, driver_version, opencl_version;
  DeviceType type = DeviceType::other;
  u32 compute_units = 0;
  u32 float_width = 1;               // native vector width
  bool fp64 = false;                 // double precision
  bool correct_divide_sqrt = false;  // offers -cl-fp32-correctly-rounded-divide-sqrt
  bool denormals = false;            // keeps float denormals
};

/// Every device of every platform; empty where there is no OpenCL at all. pocl's second device for the same processor,
/// without threads, is no device of its own here (runs_in_caller()).
const std::vector<DeviceInfo>& list_devices();

/// Whether one thread of the device can be the one that waits for it: true of a CPU device by pocl 3, unless
/// $POCL_DEVICES says which devices pocl has.
bool runs_in_caller(const DeviceInfo& device);

/// "auto" (a GPU if there is one, else a CPU device, else the reference), "gpu", "cpu", "reference", or an index of
/// list_devices(). Nothing: the reference. Throws Error (input) for another word,
/// and where there is no such device.
std::optional<DeviceInfo> select_device(std::string_view choice);

}  // namespace lockstep
