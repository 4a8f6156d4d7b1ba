#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "top_level_shapes.h"
#include "tree.h"
#include "types.h"

kernel void sort_shapes_clear(global WorldBox* world_boxes, const StepParams params) {
  FOR_EACH(w, params.worlds) {
    const WorldBox nothing = {{NONE, NONE, NONE}, {0u, 0u, 0u}};
    world_boxes[w] = nothing;
  }
}

static inline void widen_world(global WorldBox* world_box, WorldBox box) {
  for (u32 k = 0u; k < 3u; ++k) {
    if (box.low[k] < world_box->low[k]) atomic_min(&world_box->low[k], box.low[k]);
    if (box.high[k] > world_box->high[k]) atomic_max(&world_box->high[k], box.high[k]);
  }
}

// A work-item takes a chunk of shapes, most of them of one world, so that the words of a world are not fought over.
kernel void sort_shapes_bound(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                              global const u32* top_level_shapes, global const Bound* bounds,
                              global WorldBox* world_boxes, const StepParams params) {
  const u32 count = top_level_count(&params);
  FOR_EACH(chunk, (count + CHUNK - 1u) / CHUNK) {
    const WorldBox nothing = {{NONE, NONE, NONE}, {0u, 0u, 0u}};
    WorldBox box = nothing;
    u32 world = NONE;
    const u32 begin = chunk * CHUNK;
    const u32 end = CHUNK < count - begin ? begin + CHUNK : count;
    for (u32 i = begin; i < end; ++i) {
      if (!(bounds[i].extent > (real)0)) continue;
      const u32 mine = body_infos[shape_infos[TOP_LEVEL_SHAPE(i)].body].world;
      if (mine != world) {
        if (world != NONE) widen_world(&world_boxes[world], box);
        world = mine;
        box = nothing;
      }
      for (u32 k = 0u; k < 3u; ++k) {
        const u32 word = ordered_word((float)bounds[i].center[k]);
        box.low[k] = word < box.low[k] ? word : box.low[k];
        box.high[k] = word > box.high[k] ? word : box.high[k];
      }
    }
    if (world != NONE) widen_world(&world_boxes[world], box);
  }
}

kernel void sort_shapes_keys(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                             global const u32* top_level_shapes, global const Bound* bounds,
                             global const WorldBox* world_boxes, global u32* low_keys, global u32* high_keys,
                             global u32* values, global const u32* counters, const StepParams params) {
  FOR_EACH(i, top_level_count(&params)) {
    u32 low_key = 0x00ffffffu, high_key = 0x07ffffffu;
    if (bounds[i].extent > (real)0) {
      const u32 world = body_infos[shape_infos[TOP_LEVEL_SHAPE(i)].body].world;
      float low[3], width = 0.0f;
      for (u32 k = 0u; k < 3u; ++k) {
        low[k] = ordered_float(world_boxes[world].low[k]);
        const float side = ordered_float(world_boxes[world].high[k]) - low[k];
        width = side > width ? side : width;
      }
      const u32 x = curve_cell(bounds[i].center[0], low[0], width);
      const u32 y = curve_cell(bounds[i].center[1], low[1], width);
      const u32 z = curve_cell(bounds[i].center[2], low[2], width);
      const u32 size = size_class(bounds[i].extent, counters[COUNTER_MAX_EXTENT]);
      low_key = morton_bytes(x, y, z);
      high_key = (size << 24) | morton_bytes(x >> 8, y >> 8, z >> 8);
    }
    low_keys[i] = low_key;
    high_keys[i] = high_key;
    values[i] = i;
  }
}

// The next words to sort by, in the order that there is.
kernel void sort_shapes_next(global const u32* high_keys, global const u32* values, global u32* keys,
                             const StepParams params) {
  FOR_EACH(slot, top_level_count(&params)) { keys[slot] = high_keys[values[slot]]; }
}

kernel void sort_shapes_worlds(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                               global const u32* top_level_shapes, global const u32* values, global u32* keys,
                               const StepParams params) {
  FOR_EACH(slot, top_level_count(&params)) {
    keys[slot] = body_infos[shape_infos[TOP_LEVEL_SHAPE(values[slot])].body].world;
  }
}
