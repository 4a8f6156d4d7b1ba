// The tree of bounds: shapes in the order of a space-filling curve, the smaller before the larger; a node holds PACK
// neighbours. cpu_reference/tree.hpp is the twin and says more.
#ifndef LOCKSTEP_TREE_H
#define LOCKSTEP_TREE_H

#include "grid.h"

// Enough for every u32 number of shapes.
#define TREE_LEVELS 8u
#define TREE_FAR ((real)3e38)  // box of nothing
#define CELL_BITS 16u

static inline u32 ordered_word(float x) {
  const u32 bits = as_uint(x);
  return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
static inline float ordered_float(u32 word) {
  return as_float((word & 0x80000000u) != 0u ? word ^ 0x80000000u : ~word);
}

// Bits of a byte, three apart.
static inline u32 spread_byte(u32 x) {
  x = (x | (x << 8)) & 0x0000f00fu;
  x = (x | (x << 4)) & 0x000c30c3u;
  return (x | (x << 2)) & 0x00249249u;
}
static inline u32 morton_bytes(u32 x, u32 y, u32 z) {
  return spread_byte(x & 255u) | (spread_byte(y & 255u) << 1) | (spread_byte(z & 255u) << 2);
}

static inline u32 curve_cell(real x, float low, float width) {
  const real cells = (real)((1u << CELL_BITS) - 1u);
  const real at = width > 0.0f ? (x - (real)low) / (real)width * cells : (real)0;
  if (!(at > (real)0)) return 0u;
  return at < cells ? (u32)at : (1u << CELL_BITS) - 1u;
}

static inline u32 size_class(real extent, u32 max_extent_bits) {
  const real largest = (real)as_float(max_extent_bits);
  u32 size = 7u;
  for (real x = (real)4 * extent; size > 0u && x <= largest; x = (real)4 * x) --size;
  return size;
}

static inline u32 blocks_of(u32 count) { return (count + PACK - 1u) / PACK; }

// The block at which each level starts, from the lowest up.
typedef struct TreeShape {
  u32 first[TREE_LEVELS];
  u32 levels;
} TreeShape;

static inline TreeShape tree_shape(u32 shapes) {
  TreeShape tree;
  tree.levels = 0u;
  u32 first = 0u, entries = shapes;
  do {
    entries = blocks_of(entries);
    tree.first[tree.levels] = first;
    ++tree.levels;
    first += blocks_of(entries);
  } while (entries > PACK);
  return tree;
}

typedef struct TreeBox {
  Vec3 low, high;
} TreeBox;

static inline real box_reach(real center, real box) {
  const real rounding = sizeof(real) == 4 ? (real)5e-7 : (real)1e-15;
  return box * (real)1.0001 + fabs(center) * rounding;
}

static inline TreeBox swept_box(global const Bound* bound, u32 kind, global const Vec4* position,
                                global const Motion* motion, real h) {
  const Vec3 center = make3(bound->center[0], bound->center[1], bound->center[2]);
  Vec3 box = make3(bound->extent, bound->extent, bound->extent);
#if FEATURE_MANIFOLDS
  if (kind != SHAPE_SPHERE) {
    const Vec3 v = point_velocity(motion, sub3(center, make3(position->x, position->y, position->z)));
    const real turning = length3(make3(motion->w[0], motion->w[1], motion->w[2])) * bound->reach;
    box = make3(bound->box[0] + h * (fabs(v.x) + turning), bound->box[1] + h * (fabs(v.y) + turning),
                bound->box[2] + h * (fabs(v.z) + turning));
  }
#endif
  const Vec3 reach = make3(box_reach(center.x, box.x), box_reach(center.y, box.y), box_reach(center.z, box.z));
  TreeBox swept;
  swept.low = sub3(center, reach);
  swept.high = add3(center, reach);
  return swept;
}

#endif
