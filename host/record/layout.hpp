// How a compiled scene and its state are laid out in files: which settings there are, how long a list is, words of
// records.
#pragma once

#include <algorithm>

#include "host/buffers.hpp"

namespace lockstep {

// The parameters that a scene sets; the others follow from the sizes.
template <class Params, class Function>
void for_each_setting(Params& p, Function&& function) {
#define STEP_DERIVED(step_type, name, meaning) function(#name, p.name);
#define STEP_NUMBER(type, name, initial, bounds, unit, group, meaning) function(#name, p.name);
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) function(#name, p.name);
#include "kernels/step_settings.def"
}

// A record in words: as many as it has, of `real` or, where it holds integers, of u32.
template <class real>
struct Words {
  bool integers;
  std::size_t columns;

  explicit Words(Buffer buffer) {
    const BufferInfo& about = info(buffer);
    integers = about.float_bytes == about.double_bytes;
    columns = about.template element_bytes<real>() / (integers ? sizeof(u32) : sizeof(real));
  }
};

// Records of a buffer that mean something: the lists of a state are as long as their counts say.
template <class real>
std::size_t rows_in_use(Buffer buffer, const Buffers<real>& buffers, std::size_t capacity) {
  const auto first = [](const std::vector<u32>& count) { return count.empty() ? 0 : count[0]; };
  switch (info(buffer).domain) {
    case Domain::cached: return std::min<std::size_t>(first(buffers.cached_count), capacity);
    case Domain::slept: return std::min<std::size_t>(first(buffers.slept_count), capacity);
    case Domain::touches: return std::min<std::size_t>(first(buffers.touching_count), capacity);
    case Domain::springs: return std::min<std::size_t>(first(buffers.spring_count), capacity);
    default: return capacity;
  }
}

}  // namespace lockstep
