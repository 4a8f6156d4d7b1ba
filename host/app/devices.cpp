#include "host/device/devices.hpp"

#include <fmt/format.h>

#include "host/app/commands.hpp"
#include "host/backends/canary.hpp"
#include "host/error.hpp"
#include "host/render/renderer.hpp"

namespace lockstep::app {

namespace {

const char* type_name(DeviceType type) {
  switch (type) {
    case DeviceType::cpu: return "CPU";
    case DeviceType::gpu: return "GPU";
    case DeviceType::other: return "other";
  }
  return "";
}

void print_device(const DeviceInfo& device) {
  fmt::print("{}  {} ({}, {} compute units, native float width {})\n", device.index, device.name,
             type_name(device.type), device.compute_units, device.float_width);
  fmt::print("   platform   {}, {}, driver {}\n", device.platform, device.opencl_version, device.driver_version);
  fmt::print("   canary     float: {}\n", verdict_in_words(device, false));
  fmt::print("              double: {}\n", device.fp64 ? verdict_in_words(device, true) : "not offered");
  fmt::print("   promises   {}; {}\n",
             device.correct_divide_sqrt ? "correctly rounded division and square root"
                                        : "does NOT promise correctly rounded division and square root",
             device.denormals ? "keeps denormals" : "does NOT keep denormals");
}

std::string pictures() {
  try {
    return picture_driver();
  } catch (const Error& error) {
    return std::string("none: ") + error.what();
  }
}

void list() {
  const std::vector<DeviceInfo>& devices = list_devices();
  for (const DeviceInfo& device : devices) print_device(device);
  if (devices.empty()) fmt::print("no OpenCL device (Debian: apt-get install pocl-opencl-icd)\n");
  fmt::print("reference  plain C++, one thread: what every device is compared with\n");
  const std::optional<DeviceInfo> chosen = select_device("auto");
  fmt::print("pictures   {}\n", pictures());
  fmt::print("auto is {}\n", chosen ? fmt::format("{}  {}", chosen->index, chosen->name) : "the reference");
}

}  // namespace

void add_devices(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("devices", "List the devices, whether each is bit-exact, and what it supports");
  command->footer("Example:\n  lockstep devices");
  command->callback(list);
}

}  // namespace lockstep::app
