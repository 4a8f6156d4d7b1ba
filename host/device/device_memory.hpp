// The device's side of the buffer table, and the scratch arrays of the launch functions.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "host/buffers.hpp"
#include "host/device/device.hpp"

namespace lockstep {

/// A buffer with a number of its own: a handle may come back after its buffer is gone, the number does not.
struct DeviceArray {
  cl::Buffer buffer;
  std::size_t bytes = 0;
  std::uint64_t id = 0;
};

class DeviceMemory {
 public:
  DeviceMemory(Device& device, cl::CommandQueue queue);

  /// The buffer; a small dummy where the scene has none.
  const DeviceArray& of(Buffer buffer) const { return buffers_[static_cast<u32>(buffer)]; }

  /// The buffer or scratch array of that name, or null.
  const DeviceArray* find(std::string_view name) const;

  /// Changes whenever an array is made anew.
  std::uint64_t version() const { return last_id_; }

  /// Makes room for `bytes` bytes, zeroed behind the first `kept` bytes, which stay as they are.
  void allocate(Buffer buffer, std::size_t bytes, std::size_t kept);

  /// A scratch array of at least so many u32 words; its contents may be lost.
  void scratch(std::string_view name, std::size_t words);

 private:
  DeviceArray make(std::size_t bytes);

  Device& device_;
  cl::CommandQueue queue_;
  std::array<DeviceArray, buffer_count> buffers_;
  std::map<std::string, DeviceArray, std::less<>> scratch_;
  std::uint64_t last_id_ = 0;
};

}  // namespace lockstep
