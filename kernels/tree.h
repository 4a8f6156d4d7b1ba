// The tree of bounds: shapes in the order of a space-filling curve, the smaller before the larger; a node holds PACK
// neighbours. cpu_reference/tree.hpp is the twin and says more.
#ifndef LOCKSTEP_TREE_H
#define LOCKSTEP_TREE_H

#include "common.h"
#include "grid.h"
#include "lanes.h"

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

// The block at which each level starts, from the lowest up; the lowest has so many entries.
typedef struct TreeShape {
  u32 first[TREE_LEVELS];
  u32 levels;
} TreeShape;

static inline TreeShape tree_shape(u32 entries) {
  TreeShape tree;
  tree.levels = 1u;
  tree.first[0] = 0u;
  for (; entries > PACK; entries = blocks_of(entries)) {
    tree.first[tree.levels] = tree.first[tree.levels - 1u] + blocks_of(entries);
    ++tree.levels;
  }
  return tree;
}

typedef struct TreeBox {
  Vec3 low, high;
} TreeBox;

static inline real padded_extent(real center, real box) {
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
    const real rotational_speed = length3(make3(motion->w[0], motion->w[1], motion->w[2])) * bound->bounding_radius;
    box = make3(bound->box[0] + h * (fabs(v.x) + rotational_speed), bound->box[1] + h * (fabs(v.y) + rotational_speed),
                bound->box[2] + h * (fabs(v.z) + rotational_speed));
  }
#endif
  const Vec3 half_extents =
      make3(padded_extent(center.x, box.x), padded_extent(center.y, box.y), padded_extent(center.z, box.z));
  TreeBox swept;
  swept.low = sub3(center, half_extents);
  swept.high = add3(center, half_extents);
  return swept;
}

static inline TreeBox widened(TreeBox box, real by) {
  const Vec3 all = make3(by, by, by);
  box.low = sub3(box.low, all);
  box.high = add3(box.high, all);
  return box;
}

// Bit k is set where box k of a block meets this one.
static inline u32 boxes_in_range(global const BoxBlock* block, TreeBox box) {
  u32 hits = 0u;
  for (u32 k = 0u; k < PACK; k += LANES) {
    const u32 bits =
        LANE_BITS((LANE_LOAD(block->low_x + k) <= box.high.x) & (LANE_LOAD(block->high_x + k) >= box.low.x) &
                  (LANE_LOAD(block->low_y + k) <= box.high.y) & (LANE_LOAD(block->high_y + k) >= box.low.y) &
                  (LANE_LOAD(block->low_z + k) <= box.high.z) & (LANE_LOAD(block->high_z + k) >= box.low.z));
    hits |= bits << k;
  }
  return hits;
}

// Bits of the entries of a block that hold any of the slots first .. last, where each holds 2^shift.
static inline u32 entries_between(u32 block, u32 shift, u32 first, u32 last) {
  const u32 entry = block * PACK, from = first >> shift, to = last >> shift;
  u32 bits = (1u << PACK) - 1u;
  if (from > entry) bits = from - entry < PACK ? bits & ~((1u << (from - entry)) - 1u) : 0u;
  if (to < entry) return 0u;
  if (to - entry < PACK - 1u) bits &= (2u << (to - entry)) - 1u;
  return bits;
}

// A traversal of a tree, from the top down: with the entries still to traverse of each level on the path. The caller
// says, as bits, which entries of a block it arrives at are to be traversed.
typedef struct TreeWalk {
  u32 rest[TREE_LEVELS];
  u32 level, block;
} TreeWalk;

static inline TreeWalk tree_begin(const TreeShape* tree, u32 bits) {
  TreeWalk walk;
  walk.level = tree->levels - 1u;
  walk.block = 0u;
  walk.rest[walk.level] = bits;
  return walk;
}

// The next entry, NONE behind the last. One that is not of the lowest level is the block that the walk arrives at.
static inline u32 tree_next(TreeWalk* walk, const TreeShape* tree, bool* arrives) {
  while (walk->rest[walk->level] == 0u) {
    if (walk->level + 1u == tree->levels) return NONE;
    ++walk->level;
    walk->block /= PACK;
  }
  const u32 rest = walk->rest[walk->level], entry = walk->block * PACK + lowest_bit(rest);
  walk->rest[walk->level] = rest & (rest - 1u);
  *arrives = walk->level > 0u;
  if (*arrives) {
    --walk->level;
    walk->block = entry;
  }
  return entry;
}

#endif
