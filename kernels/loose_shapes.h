// The shapes that the broad phase looks at one by one. cpu_reference/loose_shapes.hpp is the twin.
#ifndef LOCKSTEP_LOOSE_SHAPES_H
#define LOCKSTEP_LOOSE_SHAPES_H

#include "types.h"

// The k-th of them, where a kernel has `loose_shapes`.
#if FEATURE_SHAPE_TREES
#define LOOSE_SHAPE(k) loose_shapes[k]
#else
#define LOOSE_SHAPE(k) (k)
#endif

// Those of a world.
typedef struct LooseRange {
  u32 first, count;
} LooseRange;

static inline LooseRange loose_range(u32 world, global const WorldRange* world_ranges,
                                     global const WorldTrees* world_trees) {
  LooseRange range;
#if FEATURE_SHAPE_TREES
  range.first = world_trees[world].first_loose;
  range.count = world_trees[world].loose_count;
#else
  range.first = world_ranges[world].first_shape;
  range.count = world_ranges[world].shape_count;
#endif
  return range;
}

static inline u32 loose_count(const StepParams* params) { return params->shapes - params->tree_shapes; }

#endif
