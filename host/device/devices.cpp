#include "host/device/devices.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>

#include "host/device/device.hpp"
#include "host/device/pocl_cache.hpp"

namespace lockstep {

namespace {

struct Listing {
  std::vector<DeviceInfo> infos;
  std::vector<DeviceHandles> handles;
};

// Strings of some drivers end in blanks or a NUL of their own.
std::string trimmed(std::string text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

// Asks pocl 3 for both of its CPU devices: `pthread` and, without threads, `basic`. It has the second one only where
// the environment names it when devices are first listed; the environment is left as it was, and a user's word stands.
class AskForBoth {
 public:
  explicit AskForBoth(const cl::Platform& platform)
      : asks_(platform.getInfo<CL_PLATFORM_VERSION>().find("PoCL 3.") != std::string::npos && !std::getenv(variable)) {
    if (asks_) ::setenv(variable, "pthread basic", 0);
  }
  AskForBoth(const AskForBoth&) = delete;
  AskForBoth& operator=(const AskForBoth&) = delete;
  ~AskForBoth() {
    if (asks_) ::unsetenv(variable);
  }
  bool is_threadless(const cl::Device& device) const { return asks_ && device_name(device).starts_with("basic-"); }

 private:
  static constexpr const char* variable = "POCL_DEVICES";
  bool asks_;
};

DeviceType type_of(const cl::Device& device) {
  const cl_device_type type = device.getInfo<CL_DEVICE_TYPE>();
  if (type & CL_DEVICE_TYPE_GPU) return DeviceType::gpu;
  return type & CL_DEVICE_TYPE_CPU ? DeviceType::cpu : DeviceType::other;
}

DeviceInfo describe(const cl::Device& device, const std::string& platform, u32 index) {
  const cl_device_fp_config single = device.getInfo<CL_DEVICE_SINGLE_FP_CONFIG>();
  DeviceInfo info;
  info.index = index;
  info.name = device_name(device);
  info.vendor = trimmed(device.getInfo<CL_DEVICE_VENDOR>());
  info.platform = platform;
  info.driver_version = trimmed(device.getInfo<CL_DRIVER_VERSION>());
  info.opencl_version = trimmed(device.getInfo<CL_DEVICE_VERSION>());
  info.type = type_of(device);
  info.compute_units = device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
  info.float_width = std::max(1u, device.getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT>());
  info.fp64 = device.getInfo<CL_DEVICE_DOUBLE_FP_CONFIG>() != 0;
  info.correct_divide_sqrt = (single & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  info.denormals = (single & CL_FP_DENORM) != 0;
  return info;
}

// A platform whose driver fails is left out, so that one broken driver does not hide the devices of the others.
template <class List>
auto or_nothing(List&& list) -> decltype(list()) {
  try {
    return list();
  } catch (const cl::Error&) {
    return {};
  }
}

constexpr std::string_view pocl_name = "Portable Computing Language";

bool is_pocl(const cl::Platform& platform) { return trimmed(platform.getInfo<CL_PLATFORM_NAME>()) == pocl_name; }

std::vector<cl::Platform> platforms() {
  std::vector<cl::Platform> found;
  cl::Platform::get(&found);
  return found;
}

std::vector<DeviceHandles> devices_of(const cl::Platform& platform) {
  const AskForBoth both(platform);
  std::vector<cl::Device> found;
  platform.getDevices(CL_DEVICE_TYPE_ALL, &found);
  cl::Device threadless;
  std::vector<DeviceHandles> devices;
  for (const cl::Device& device : found) {
    if (both.is_threadless(device))
      threadless = device;
    else
      devices.push_back({device, {}});
  }
  for (DeviceHandles& handles : devices)
    if (type_of(handles.device) == DeviceType::cpu) handles.threadless = threadless;
  return devices;
}

void tell(const std::string& line) { std::fprintf(stderr, "lockstep: %s\n", line.c_str()); }

Listing make_listing() {
  Listing listing;
  const bool pocl_can_build = prepare_pocl_cache(tell);
  for (const cl::Platform& platform : or_nothing(platforms)) {
    if (!pocl_can_build && is_pocl(platform)) continue;
    for (const DeviceHandles& handles : or_nothing([&] { return devices_of(platform); })) {
      const std::vector<DeviceInfo> info = or_nothing([&] {
        const std::string name = trimmed(platform.getInfo<CL_PLATFORM_NAME>());
        return std::vector<DeviceInfo>{describe(handles.device, name, static_cast<u32>(listing.infos.size()))};
      });
      if (info.empty()) continue;
      listing.infos.push_back(info.front());
      listing.handles.push_back(handles);
    }
  }
  return listing;
}

// Never destroyed: drivers may be gone when destructors of static objects run. Drivers have threads, which a child of
// fork() is without: what it asks of them is never answered.
const Listing& listing() {
  static const pid_t process = getpid();
  if (process != getpid())
    throw Error(
        Failure::device, "OpenCL",
        "was in use before fork(), and its threads are not in this process; compute on 'reference' here, or start "
        "processes by exec (in Python multiprocessing.set_start_method('spawn'))");
  static const Listing& once = *new Listing(make_listing());
  return once;
}

std::optional<DeviceInfo> first_of(DeviceType type) {
  for (const DeviceInfo& device : list_devices())
    if (device.type == type) return device;
  return std::nullopt;
}

DeviceInfo need(DeviceType type, const char* name) {
  if (const auto device = first_of(type)) return *device;
  throw Error(Failure::input, "--device", std::string("there is no OpenCL ") + name + " on this machine");
}

}  // namespace

bool is_pocl(const DeviceInfo& device) { return device.platform == pocl_name; }
const std::vector<DeviceInfo>& list_devices() { return listing().infos; }
const std::vector<DeviceHandles>& device_handles() { return listing().handles; }
std::string device_name(const cl::Device& device) { return trimmed(device.getInfo<CL_DEVICE_NAME>()); }
bool runs_in_caller(const DeviceInfo& device) { return device_handles().at(device.index).threadless() != nullptr; }

std::optional<DeviceInfo> select_device(std::string_view choice) {
  if (choice == "reference") return std::nullopt;
  if (choice == "gpu") return need(DeviceType::gpu, "GPU");
  if (choice == "cpu") return need(DeviceType::cpu, "CPU device (Debian: pocl-opencl-icd)");
  if (choice == "auto") {
    const auto gpu = first_of(DeviceType::gpu);
    return gpu ? gpu : first_of(DeviceType::cpu);
  }
  u32 index = 0;
  const auto [end, error] = std::from_chars(choice.data(), choice.data() + choice.size(), index);
  if (error != std::errc() || end != choice.data() + choice.size())
    throw Error(Failure::input, "--device",
                "must be auto, gpu, cpu, reference or an index, is '" + std::string(choice) + "'");
  if (index >= list_devices().size())
    throw Error(
        Failure::input, "--device",
        "there is no device " + std::to_string(index) + ", OpenCL offers " + std::to_string(list_devices().size()));
  return list_devices()[index];
}

}  // namespace lockstep
