// Broad phase on the tree of bounds (cpu_reference/tree.hpp): pairs of shapes that can touch within the step
// (cpu_reference/pair_test.hpp). What is found, and its order, is what the grid finds; shapes may differ in size as
// they like.
#pragma once

#include "cpu_reference/tree.hpp"

namespace lockstep::reference {

/// A shape that looks for others in the part of the tree that is its world's.
template <class real>
struct TreeSearch {
  const Buffers<real>& b;
  const StepParams<real>& params;
  u32 shape;
  TreeBox<real> box;
  u32 first_place, end_place;
  std::vector<u32>& found;

  bool in_reach(const BoxBlock<real>& block, u32 k) const {
    return block.low_x[k] <= box.high.x && block.high_x[k] >= box.low.x && block.low_y[k] <= box.high.y &&
           block.high_y[k] >= box.low.y && block.low_z[k] <= box.high.z && block.high_z[k] >= box.low.z;
  }

  void visit_run(u32 run) {
    for (u32 place = run * PACK; place < (run + 1) * PACK; ++place) {
      if (place < first_place || place >= end_place) continue;
      const u32 j = b.tree_items[place];
      if (j > shape && b.bounds[j].extent > 0 && is_pair(b, shape, j) && shapes_in_reach(b, params, shape, j))
        found.push_back(j);
    }
  }

  /// The block at this place of its level; `first` is where the level starts and `entries` how many boxes it has.
  void visit_block(u32 block, u32 first, u32 entries, u32 shapes_below) {
    for (u32 k = 0; k < PACK; ++k) {
      const u32 entry = block * PACK + k;
      if (entry >= entries || !in_reach(b.tree_blocks[first + block], k)) continue;
      if (shapes_below == PACK) {
        visit_run(entry);
      } else {
        // below an entry is the block of its number: the level before, that has as many blocks as this has entries
        visit_block(entry, first - entries, level_entries(shapes_below / PACK), shapes_below / PACK);
      }
    }
  }

  /// Boxes of the level whose boxes hold up to so many shapes.
  u32 level_entries(u32 shapes_below) const {
    u32 entries = params.shapes;
    for (u32 n = 1; n < shapes_below; n *= PACK) entries = blocks_of(entries);
    return entries;
  }

  void visit_tree() {
    u32 first = 0, shapes_below = PACK, entries = blocks_of(params.shapes);
    for (; entries > PACK; shapes_below *= PACK) {
      first += blocks_of(entries);
      entries = blocks_of(entries);
    }
    visit_block(0, first, entries, shapes_below);
  }
};

template <class real>
void search_tree(Buffers<real>& b, const StepParams<real>& params) {
  const real margin = params.margin * real(1.0001);
  list_pairs(b, params, [&](u32 i, std::vector<u32>& found) {
    TreeBox<real> box = swept_box(b, i, step_length(params));
    box.low = sub3(box.low, Vec3<real>{margin, margin, margin});
    box.high = add3(box.high, Vec3<real>{margin, margin, margin});
    const WorldRange& world = b.world_ranges[b.body_infos[b.shape_infos[i].body].world];
    TreeSearch<real>{b, params, i, box, world.first_shape, world.first_shape + world.shape_count, found}.visit_tree();
    return true;
  });
}

}  // namespace lockstep::reference
