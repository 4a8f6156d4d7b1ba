#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "top_level_shapes.h"
#include "tree.h"
#include "types.h"

static inline TreeBox empty_box(void) {
  TreeBox box;
  box.low = make3(TREE_FAR, TREE_FAR, TREE_FAR);
  box.high = make3(-TREE_FAR, -TREE_FAR, -TREE_FAR);
  return box;
}

static inline TreeBox united(TreeBox a, TreeBox b) {
  TreeBox box;
  box.low = make3(b.low.x < a.low.x ? b.low.x : a.low.x, b.low.y < a.low.y ? b.low.y : a.low.y,
                  b.low.z < a.low.z ? b.low.z : a.low.z);
  box.high = make3(b.high.x > a.high.x ? b.high.x : a.high.x, b.high.y > a.high.y ? b.high.y : a.high.y,
                   b.high.z > a.high.z ? b.high.z : a.high.z);
  return box;
}

static inline void set_box(global BoxBlock* block, u32 k, TreeBox box) {
  block->low_x[k] = box.low.x;
  block->low_y[k] = box.low.y;
  block->low_z[k] = box.low.z;
  block->high_x[k] = box.high.x;
  block->high_y[k] = box.high.y;
  block->high_z[k] = box.high.z;
}

// The lowest level: boxes of runs of shapes.
kernel void build_tree_runs(global const ShapeInfo* shape_infos, global const u32* top_level_shapes,
                            global const Vec4* positions, global const Motion* motions, global const Bound* bounds,
                            global const u32* tree_items, global BoxBlock* tree_blocks, const StepParams params) {
  const u32 count = top_level_count(&params);
  FOR_EACH(e, blocks_of(blocks_of(count)) * PACK) {
    TreeBox box = empty_box();
    for (u32 slot = e * PACK; slot < (e + 1u) * PACK && slot < count; ++slot) {
      const u32 k = tree_items[slot], i = TOP_LEVEL_SHAPE(k), body = shape_infos[i].body;
      if (bounds[k].extent > (real)0)
        box = united(
            box, swept_box(&bounds[k], shape_infos[i].kind, &positions[body], &motions[body], step_length(&params)));
    }
    set_box(&tree_blocks[e / PACK], e % PACK, box);
  }
}

// A level above: boxes of the `entries` blocks from `below` on.
kernel void build_tree_level(global BoxBlock* tree_blocks, const u32 below, const u32 entries) {
  const u32 first = below + entries;
  FOR_EACH(e, blocks_of(entries) * PACK) {
    TreeBox box = empty_box();
    if (e < entries) {
      global const BoxBlock* block = &tree_blocks[below + e];
      for (u32 k = 0u; k < PACK; ++k) {
        TreeBox other;
        other.low = make3(block->low_x[k], block->low_y[k], block->low_z[k]);
        other.high = make3(block->high_x[k], block->high_y[k], block->high_z[k]);
        box = united(box, other);
      }
    }
    set_box(&tree_blocks[first + e / PACK], e % PACK, box);
  }
}
