// The shapes that the broad phase looks at one by one. cpu_reference/top_level_shapes.hpp is the twin.
#ifndef LOCKSTEP_TOP_LEVEL_SHAPES_H
#define LOCKSTEP_TOP_LEVEL_SHAPES_H

#include "types.h"

// The k-th of them, where a kernel has `top_level_shapes`.
#if FEATURE_SHAPE_TREES
#define TOP_LEVEL_SHAPE(k) top_level_shapes[k]
#else
#define TOP_LEVEL_SHAPE(k) (k)
#endif

// Those of a world.
typedef struct TopLevelRange {
  u32 first, count;
} TopLevelRange;

static inline TopLevelRange top_level_range(u32 world, global const WorldRange* world_ranges,
                                            global const WorldTrees* world_trees) {
  TopLevelRange range;
#if FEATURE_SHAPE_TREES
  range.first = world_trees[world].first_top_level;
  range.count = world_trees[world].top_level_count;
#else
  range.first = world_ranges[world].first_shape;
  range.count = world_ranges[world].shape_count;
#endif
  return range;
}

static inline u32 top_level_count(const StepParams* params) { return params->shapes - params->tree_shapes; }

#endif
