// Broad phase on the tree of bounds (cpu_reference/tree.hpp): pairs of shapes that can touch within the step
// (cpu_reference/pair_test.hpp). What is found, and its order, is what the grid finds; shapes may differ in size as
// they like.
#pragma once

#include "cpu_reference/list_pairs.hpp"

namespace lockstep::reference {

template <class real>
void search_tree(Buffers<real>& b, const StepParams<real>& params) {
  const u32 count = top_level_count(params);
  list_pairs(b, params, [&](u32, const Bounded<real>& me, std::vector<u32>& found) {
    const TreeBox<real> box = swept_box(b, me, step_length(params));
    const TopLevelRange range = top_level_range(b, b.body_infos[b.shape_infos[me.shape].body].world);
    traverse_boxes(b.tree_blocks.data(), blocks_of(count), box, [&](u32 run) {
      for (u32 slot = run * PACK; slot < std::min((run + 1) * PACK, count); ++slot) {
        if (slot < range.first || slot >= range.first + range.count) continue;
        const Bounded<real> other = top_level(b, b.tree_items[slot]);
        if (other.shape > me.shape && are_pair(b, params, me, other)) found.push_back(other.shape);
      }
    });
    return true;
  });
}

}  // namespace lockstep::reference
