// How a compiled scene and its state are laid out in files: which settings there are, how long a list is, words of
// records.
#pragma once

#include <algorithm>

#include "host/buffers.hpp"

namespace lockstep {

// The parameters that a scene sets; the others follow from the sizes. A new one belongs into this list.
template <class Params, class Function>
void for_each_setting(Params& p, Function&& function) {
  function("dt", p.dt);
  function("theta", p.theta);
  function("gyroscopic_theta", p.gyroscopic_theta);
  function("restitution_threshold", p.restitution_threshold);
  function("correction", p.correction);
  function("softness", p.softness);
  function("correction_limit", p.correction_limit);
  function("slop", p.slop);
  function("margin", p.margin);
  function("speed_limit", p.speed_limit);
  function("tolerance", p.tolerance);
  function("iterations", p.iterations);
  function("relaxations", p.relaxations);
  function("substeps", p.substeps);
  function("position_sweeps", p.position_sweeps);
  function("gyroscopic", p.gyroscopic);
}
// 16 settings; bodies, shapes, worlds, tree_shapes, buckets, five capacities, substep, queries and joint_blocks
static_assert(sizeof(StepParams<float>) == (16 + 13) * sizeof(u32), "for_each_setting: is there a new parameter?");

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
