// How a compiled scene and its state are laid out in files: which settings there are, how long a list is, words of
// records.
#pragma once

#include <algorithm>

#include "host/buffers.hpp"

namespace lockstep {

// The parameters that a scene sets; the others follow from the sizes. A new one belongs into this list.
template <class Params, class Visitor>
void for_each_setting(Params& p, Visitor&& visit) {
  visit("dt", p.dt);
  visit("theta", p.theta);
  visit("gyroscopic_theta", p.gyroscopic_theta);
  visit("restitution_threshold", p.restitution_threshold);
  visit("correction", p.correction);
  visit("softness", p.softness);
  visit("correction_limit", p.correction_limit);
  visit("slop", p.slop);
  visit("margin", p.margin);
  visit("speed_limit", p.speed_limit);
  visit("tolerance", p.tolerance);
  visit("iterations", p.iterations);
  visit("relaxations", p.relaxations);
  visit("substeps", p.substeps);
  visit("position_sweeps", p.position_sweeps);
  visit("gyroscopic", p.gyroscopic);
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
