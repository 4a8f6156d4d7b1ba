#include "host/device/device_memory.hpp"

#include <algorithm>

#include "host/device/kernel_source.hpp"

namespace lockstep {

namespace {

constexpr std::size_t smallest = 256;  // bytes of the dummies: more than any element

}  // namespace

DeviceMemory::DeviceMemory(Device& device, cl::CommandQueue queue) : device_(device), queue_(std::move(queue)) {
  const DeviceArray dummy = make(smallest);
  buffers_.fill(dummy);
}

const DeviceArray* DeviceMemory::find(std::string_view name) const {
  if (const auto buffer = buffer_named(name)) return &of(*buffer);
  const auto found = scratch_.find(name);
  return found == scratch_.end() ? nullptr : &found->second;
}

void DeviceMemory::allocate(Buffer buffer, std::size_t bytes, std::size_t kept) {
  DeviceArray& array = buffers_[static_cast<u32>(buffer)];
  DeviceArray larger = make(bytes);
  if (kept > 0) queue_.enqueueCopyBuffer(array.buffer, larger.buffer, 0, 0, std::min(kept, array.bytes));
  array = std::move(larger);
}

void DeviceMemory::scratch(std::string_view name, std::size_t words) {
  if (buffer_named(name)) throw Error(Failure::input, std::string(name), "a scratch array has the name of a buffer");
  const auto found = scratch_.find(name);
  if (found != scratch_.end() && found->second.bytes >= words * sizeof(u32)) return;
  scratch_.insert_or_assign(std::string(name), make(words * sizeof(u32)));
}

DeviceArray DeviceMemory::make(std::size_t bytes) {
  DeviceArray array;
  array.bytes = std::max(bytes, smallest);
  array.buffer = cl::Buffer(device_.context, CL_MEM_READ_WRITE, array.bytes);
  array.id = ++last_id_;
  queue_.enqueueFillBuffer(array.buffer, u32{0}, 0, array.bytes);
  return array;
}

}  // namespace lockstep
