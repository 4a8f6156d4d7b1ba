#include "host/backends/backend.hpp"

#include <algorithm>

namespace lockstep {

namespace {

template <class real>
struct HostCopy final : SavedBuffers {
  std::vector<Buffer> names;
  Buffers<real> buffers;
};

}  // namespace

template <class real>
std::unique_ptr<SavedBuffers> Backend<real>::save(std::span<const Buffer> wanted) {
  auto copy = std::make_unique<HostCopy<real>>();
  copy->names.assign(wanted.begin(), wanted.end());
  const Buffers<real>& current = download(wanted);
#define BUFFER(name, ...) \
  if (std::ranges::find(wanted, Buffer::name) != wanted.end()) copy->buffers.name = current.name;
#include "host/buffers.def"
#undef BUFFER
  return copy;
}

template <class real>
void Backend<real>::restore(SavedBuffers& saved) {
  auto& copy = static_cast<HostCopy<real>&>(saved);
  for_each_buffer(copy.buffers, [&](Buffer buffer, auto& elements) {
    if (std::ranges::find(copy.names, buffer) == copy.names.end()) return;
    elements.resize(std::max(elements.size(), capacity(info(buffer).domain, sizes())));
  });
  for (const Buffer buffer : copy.names) upload(buffer, copy.buffers);
}

template class Backend<float>;
template class Backend<double>;

}  // namespace lockstep
