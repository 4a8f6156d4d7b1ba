// The shapes that the broad phase looks at one by one: all but those that bodies keep trees of
// (cpu_reference/shape_trees.hpp). Its buffers are in their order.
#pragma once

#include "host/buffers.hpp"

namespace lockstep::reference {

/// The k-th of them.
template <class real>
u32 loose_shape(const Buffers<real>& b, u32 k) {
  return b.loose_shapes.empty() ? k : b.loose_shapes[k];
}

template <class real>
u32 loose_count(const StepParams<real>& params) {
  return params.shapes - params.tree_shapes;
}

/// Those of a world.
struct LooseRange {
  u32 first, count;
};
template <class real>
LooseRange loose_range(const Buffers<real>& b, u32 world) {
  if (b.world_trees.empty()) return {b.world_ranges[world].first_shape, b.world_ranges[world].shape_count};
  return {b.world_trees[world].first_loose, b.world_trees[world].loose_count};
}

}  // namespace lockstep::reference
