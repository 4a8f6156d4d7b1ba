// Broad phase of few shapes: each is compared with every later one of its world (cpu_reference/pair_test.hpp). What is
// found, and its order, is what the grid and the tree find.
#pragma once

#include "cpu_reference/list_pairs.hpp"

namespace lockstep::reference {

template <class real>
void compare_shapes(Buffers<real>& b, const StepParams<real>& params) {
  list_pairs(b, params, [&](u32 k, const Bounded<real>& me, std::vector<u32>& found) {
    const auto [first, count] = top_level_range(b, b.body_infos[b.shape_infos[me.shape].body].world);
    for (u32 n = k + 1; n < first + count; ++n) {
      const Bounded<real> other = top_level(b, n);
      if (are_pair(b, params, me, other)) found.push_back(other.shape);
    }
    return true;
  });
}

}  // namespace lockstep::reference
