// The boxes of the tree of bounds, from the shapes up (cpu_reference/tree.hpp).
#pragma once

#include <algorithm>

#include "cpu_reference/tree.hpp"

namespace lockstep::reference {

template <class real>
TreeBox<real> empty_box() {
  const real far = tree_far<real>;
  return {{far, far, far}, {-far, -far, -far}};
}

template <class real>
TreeBox<real> united(TreeBox<real> a, TreeBox<real> b) {
  return {{b.low.x < a.low.x ? b.low.x : a.low.x, b.low.y < a.low.y ? b.low.y : a.low.y,
           b.low.z < a.low.z ? b.low.z : a.low.z},
          {b.high.x > a.high.x ? b.high.x : a.high.x, b.high.y > a.high.y ? b.high.y : a.high.y,
           b.high.z > a.high.z ? b.high.z : a.high.z}};
}

template <class real>
TreeBox<real> box_of_block(const BoxBlock<real>& block) {
  TreeBox<real> box = empty_box<real>();
  for (u32 k = 0; k < PACK; ++k)
    box = united(box, TreeBox<real>{{block.low_x[k], block.low_y[k], block.low_z[k]},
                                    {block.high_x[k], block.high_y[k], block.high_z[k]}});
  return box;
}

template <class real>
void set_box(BoxBlock<real>& block, u32 k, TreeBox<real> box) {
  block.low_x[k] = box.low.x, block.low_y[k] = box.low.y, block.low_z[k] = box.low.z;
  block.high_x[k] = box.high.x, block.high_y[k] = box.high.y, block.high_z[k] = box.high.z;
}

/// The levels above the lowest, of so many entries: boxes of the blocks below.
template <class real>
void build_levels(BoxBlock<real>* blocks, u32 entries) {
  for (u32 first = 0; entries > PACK;) {
    const u32 below = first;
    first += blocks_of(entries);
    entries = blocks_of(entries);
    for (u32 e = 0; e < blocks_of(entries) * PACK; ++e)
      set_box(blocks[first + e / PACK], e % PACK, e < entries ? box_of_block(blocks[below + e]) : empty_box<real>());
  }
}

template <class real>
void build_tree(Buffers<real>& b, const StepParams<real>& params) {
  // the lowest level: boxes of runs of shapes
  const u32 count = top_level_count(params), runs = blocks_of(count);
  for (u32 e = 0; e < blocks_of(runs) * PACK; ++e) {
    TreeBox<real> box = empty_box<real>();
    for (u32 slot = e * PACK; slot < std::min((e + 1) * PACK, count); ++slot) {
      const Bounded<real> shape = top_level(b, b.tree_items[slot]);
      if (shape.bound.extent > 0) box = united(box, swept_box(b, shape, step_length(params)));
    }
    set_box(b.tree_blocks[e / PACK], e % PACK, box);
  }
  build_levels(b.tree_blocks.data(), runs);
}

}  // namespace lockstep::reference
