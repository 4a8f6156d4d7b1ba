#include "host/device/device.hpp"

#include <algorithm>
#include <memory>
#include <utility>

namespace lockstep {

namespace {

// A part of a CPU device with so many compute units; the whole device where it has no more anyway, or is no CPU.
cl::Device subdevice_of(const DeviceInfo& info, u32 threads) {
  const DeviceHandles& handles = device_handles().at(info.index);
  if (threads == 1 && handles.threadless() != nullptr) return handles.threadless;
  const cl::Device& whole = handles.device;
  if (info.type != DeviceType::cpu || threads == 0 || threads >= whole.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>())
    return whole;
  const cl_device_partition_property by_counts[] = {CL_DEVICE_PARTITION_BY_COUNTS,
                                                    static_cast<cl_device_partition_property>(threads),
                                                    CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
  std::vector<cl::Device> subdevices;
  cl::Device(whole).createSubDevices(by_counts, &subdevices);
  return subdevices.at(0);
}

std::unique_ptr<Device> open(const DeviceInfo& info, u32 threads) {
  auto device = std::make_unique<Device>();
  device->info = info;
  device->handle = subdevice_of(info, threads);
  device->info.name = device_name(device->handle);
  device->context = cl::Context(device->handle);
  device->compute_units = device->handle.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
  device->max_work_group = device->handle.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>();
  return device;
}

}  // namespace

std::recursive_mutex& device_mutex() {
  static auto& mutex = *new std::recursive_mutex;
  return mutex;
}

Device& open_device(const DeviceInfo& info, u32 threads) {
  const std::lock_guard lock(device_mutex());
  // Never destroyed: drivers may be gone when destructors of static objects run.
  static auto& opened = *new std::map<std::pair<u32, u32>, std::unique_ptr<Device>>;
  std::unique_ptr<Device>& device = opened[{info.index, threads}];
  if (!device) device = opencl_guard("opening " + info.name, [&] { return open(info, threads); });
  return *device;
}

}  // namespace lockstep
