// The shapes that the broad phase looks at one by one: all but those that bodies keep trees of
// (cpu_reference/shape_trees.hpp). Its buffers are in their order.
#pragma once

#include "host/buffers.hpp"

namespace lockstep::reference {

/// The k-th of them.
template <class real>
u32 top_level_shape(const Buffers<real>& b, u32 k) {
  return b.top_level_shapes.empty() ? k : b.top_level_shapes[k];
}

template <class real>
u32 top_level_count(const StepParams<real>& params) {
  return params.shapes - params.tree_shapes;
}

/// Those of a world.
struct TopLevelRange {
  u32 first, count;
};
template <class real>
TopLevelRange top_level_range(const Buffers<real>& b, u32 world) {
  if (b.world_trees.empty()) return {b.world_ranges[world].first_shape, b.world_ranges[world].shape_count};
  return {b.world_trees[world].first_top_level, b.world_trees[world].top_level_count};
}

}  // namespace lockstep::reference
