// Broad phase of few shapes: each is compared with every later one of its world (cpu_reference/pair_test.hpp). What is
// found, and its order, is what the grid and the tree find.
#pragma once

#include "cpu_reference/pair_test.hpp"

namespace lockstep::reference {

template <class real>
void compare_shapes(Buffers<real>& b, const StepParams<real>& params) {
  list_pairs(b, params, [&](u32 i, std::vector<u32>& found) {
    const WorldRange& world = b.world_ranges[b.body_infos[b.shape_infos[i].body].world];
    for (u32 j = i + 1; j < world.first_shape + world.shape_count; ++j) {
      if (b.bounds[j].extent > 0 && is_pair(b, i, j) && shapes_in_reach(b, params, i, j)) found.push_back(j);
    }
    return true;
  });
}

}  // namespace lockstep::reference
