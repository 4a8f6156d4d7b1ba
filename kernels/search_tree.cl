#pragma OPENCL FP_CONTRACT OFF
#include "pair_search.h"
#include "tree.h"
#include "types.h"

// Bit k is set where box k of a block meets this one.
static inline u32 boxes_in_reach(global const BoxBlock* block, TreeBox box) {
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

// Bits of the children of a block that hold any of the places first .. last, where each child holds 2^shift.
static inline u32 children_between(u32 block, u32 shift, u32 first, u32 last) {
  const u32 child = block * PACK, from = first >> shift, to = last >> shift;
  u32 bits = (1u << PACK) - 1u;
  if (from > child) bits = from - child < PACK ? bits & ~((1u << (from - child)) - 1u) : 0u;
  if (to < child) return 0u;
  if (to - child < PACK - 1u) bits &= (2u << (to - child)) - 1u;
  return bits;
}

// The shapes of a run, of these bits.
static inline void search_run(const PairSearch* s, const Searcher* me, u32 run, u32 bits, bool all, u32 shapes,
                              Finds* finds) {
  for (u32 k = 0u; k < PACK; k += LANES) {
    const u32 mine = (bits >> k) & ((2u << (LANES - 1u)) - 1u);
    if (mine == 0u) continue;
    for (u32 hits = mine & shapes_in_reach(s, me, run * PACK + k, shapes); hits != 0u; hits &= hits - 1u) {
      const u32 place = run * PACK + k + lowest_bit(hits);
      const PlaceInfo other = s->place_infos[place];
      const bool is_owner = me->info.index < other.index;
      if (all && !is_owner) continue;
#if SEARCHES_AROUND
      if (!all && place <= me->place && !is_sought(&other)) continue;
#endif
      if (!one_looks(me->info.looks, other.looks)) continue;
      if (!is_pair(s, me->info.shape, other.shape, me->info.body, other.body)) continue;
      add_pair(finds, is_owner ? me->info.index : other.index, is_owner ? other.index : me->info.index);
    }
  }
}

// The box that meets those of all partners: swept_box of the shape, and the margin.
static inline TreeBox searcher_box(const Searcher* me) {
  Vec3 box = make3(me->extent, me->extent, me->extent);
#if FEATURE_MANIFOLDS
  if (me->info.shape.kind != SHAPE_SPHERE) {
    box = make3(me->box.x + me->h * (fabs(me->velocity.x) + me->turning),
                me->box.y + me->h * (fabs(me->velocity.y) + me->turning),
                me->box.z + me->h * (fabs(me->velocity.z) + me->turning));
  }
#endif
  const real margin = me->margin * (real)1.0001;
  const Vec3 reach = make3(box_reach(me->center.x, box.x) + margin, box_reach(me->center.y, box.y) + margin,
                           box_reach(me->center.z, box.z) + margin);
  TreeBox swept;
  swept.low = sub3(me->center, reach);
  swept.high = add3(me->center, reach);
  return swept;
}

// From the top down, with the children still to visit of each level on the way. The first search looks at what comes
// later in the order: that are shapes of its size or larger ones.
static inline void search_nodes(const PairSearch* s, const TreeShape* tree, global const BoxBlock* tree_blocks,
                                StepParams params, u32 place, Finds* finds) {
  const Searcher me = make_searcher(s, params, place);
  if (!(me.extent > (real)0)) return;
  const bool all = finds->list != 0;
  if (!all && is_sought(&me.info)) {
    if (FEATURE_SLEEPING) search_planes(s, &me, finds);  // some may move
    return;
  }
  const TreeBox box = searcher_box(&me);
  const WorldRange world = s->world_ranges[me.info.body.world];
  const u32 last = world.first_shape + world.shape_count - 1u;
  const u32 first = all || SEARCHES_AROUND ? world.first_shape : place + 1u;
  u32 rest[TREE_LEVELS];
  u32 level = tree->levels - 1u, block = 0u;
  bool arrives = first <= last;
  if (!arrives) rest[level] = 0u;
  for (;;) {
    if (arrives)
      rest[level] = children_between(block, 4u * (level + 1u), first, last) &
                    boxes_in_reach(&tree_blocks[tree->first[level] + block], box);
    arrives = false;
    if (rest[level] == 0u) {
      if (level + 1u == tree->levels) break;
      ++level;
      block /= PACK;
      continue;
    }
    const u32 child = block * PACK + lowest_bit(rest[level]);
    rest[level] &= rest[level] - 1u;
    if (level == 0u) {
      search_run(s, &me, child, children_between(child, 0u, first, last), all, params.shapes, finds);
    } else {
      --level;
      block = child;
      arrives = true;
    }
  }
  search_planes(s, &me, finds);
}

// What searches read again and again: the shapes in the order of the tree, and the planes.
kernel void search_tree_gather(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                               global const ShapeInfo* shape_infos, global const Shape* shapes,
                               global const u32* planes, global const Vec4* positions, global const Vec4* orientations,
                               global const Motion* motions, global const Sleeper* sleepers, global const Bound* bounds,
                               global const u32* tree_items, global real* places, global PlaceInfo* place_infos,
                               global PlaneInfo* plane_infos, global u32* shape_places, global u32* pair_starts,
                               const StepParams params) {
  const Cell no_cell = {0, 0, 0, NONE};
  FOR_EACH(place, params.shapes) {
    gather_place(place, tree_items[place], no_cell, body_infos, shape_infos, positions, motions, sleepers, bounds,
                 places, place_infos, shape_places, params.shapes, params.bodies);
  }
  gather_planes(world_ranges, body_infos, shape_infos, shapes, planes, positions, orientations, motions, sleepers,
                plane_infos, pair_starts, params);
}

kernel void search_tree_search(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                               global const ShapeInfo* shape_infos, global const u32* planes,
                               global const Vec4* positions, global const Motion* motions,
                               global const BoxBlock* tree_blocks, global const real* places,
                               global const PlaceInfo* place_infos, global const PlaneInfo* plane_infos,
                               global const u32* joined_starts, global const u32* joined_bodies,
                               global u32* found_partners, global u32* pair_starts, const StepParams params) {
  const PairSearch s = {world_ranges, body_infos,  shape_infos, planes,        positions,    motions,
                        places,       place_infos, plane_infos, joined_starts, joined_bodies};
  const TreeShape tree = tree_shape(params.shapes);
  Finds finds = {pair_starts, found_partners, 0, 0u};
  FOR_EACH(place, params.shapes) { search_nodes(&s, &tree, tree_blocks, params, place, &finds); }
}

// After the scan of pair_starts.
kernel void search_tree_write(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                              global const ShapeInfo* shape_infos, global const u32* planes,
                              global const Vec4* positions, global const Motion* motions,
                              global const u32* shape_places, global const BoxBlock* tree_blocks,
                              global const real* places, global const PlaceInfo* place_infos,
                              global const PlaneInfo* plane_infos, global const u32* joined_starts,
                              global const u32* joined_bodies, global u32* found_partners,
                              global const u32* pair_starts, global Pair* pairs, global u32* counters,
                              const StepParams params) {
  const PairSearch s = {world_ranges, body_infos,  shape_infos, planes,        positions,    motions,
                        places,       place_infos, plane_infos, joined_starts, joined_bodies};
  const TreeShape tree = tree_shape(params.shapes);
  const bool full = tell_pairs(pair_starts[params.shapes], counters, params);
  FOR_EACH(i, full ? 0u : params.shapes) {
    const u32 start = pair_starts[i], count = pair_starts[i + 1u] - start;
    global u32* partners = found_partners + i * FOUND;
    if (count > FOUND) {
      partners = (global u32*)(pairs + start);
      Finds finds = {0, 0, partners, 0u};
      search_nodes(&s, &tree, tree_blocks, params, shape_places[i], &finds);
    }
    write_pairs(i, partners, count, pairs + start);
  }
}
