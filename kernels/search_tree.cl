#pragma OPENCL FP_CONTRACT OFF
#include "pair_search.h"
#include "shape_trees.h"
#include "tree.h"
#include "types.h"

// The shapes of a run, of these bits.
static inline void search_run(const PairSearch* s, const Searcher* me, u32 run, u32 bits, bool all, u32 shapes,
                              Finds* finds) {
  for (u32 k = 0u; k < PACK; k += LANES) {
    const u32 mine = (bits >> k) & ((2u << (LANES - 1u)) - 1u);
    if (mine == 0u) continue;
    for (u32 hits = mine & shapes_in_range(s, me, run * PACK + k, shapes); hits != 0u; hits &= hits - 1u) {
      const u32 slot = run * PACK + k + lowest_bit(hits);
      const SearchInfo other = s->search_infos[slot];
      const bool is_owner = me->info.index < other.index;
      if (all && !is_owner) continue;
#if SEARCHES_AROUND
      if (!all && slot <= me->slot && !is_sought(&other)) continue;
#endif
      if (!one_looks(me->info.looks, other.looks)) continue;
      if (!is_pair(s, me->info.shape, other.shape, me->info.body, other.body)) continue;
      add_pair(finds, is_owner ? me->info.index : other.index, is_owner ? other.index : me->info.index);
    }
  }
}

// Of a block, the boxes that meet a box and hold any of the slots first .. last.
static inline u32 nodes_in_range(const TreeShape* tree, global const BoxBlock* tree_blocks, TreeBox box, u32 level,
                                 u32 block, u32 first, u32 last) {
  return entries_between(block, 4u * (level + 1u), first, last) &
         boxes_in_range(tree_blocks + tree->first[level] + block, box);
}

// The first search looks at what comes later in the order: that are shapes of its size or larger ones.
static inline void search_nodes(const PairSearch* s, const TreeShape* tree, global const BoxBlock* tree_blocks,
                                const StepParams* params, const Searcher* me, Finds* finds) {
  if (!(me->extent > (real)0)) return;
  const bool all = finds->list != 0;
  if (!all && is_sought(&me->info)) {
    if (FEATURE_SLEEPING) search_planes_and_trees(s, params, me, finds);  // some may move
    return;
  }
  const TreeBox box = searcher_box(me);
  const TopLevelRange world = top_level_range(me->info.body.world, s->world_ranges, s->world_trees);
  const u32 first = all || SEARCHES_AROUND ? world.first : me->slot + 1u, last = world.first + world.count - 1u;
  bool arrives = true;
  TreeWalk walk = tree_begin(tree, 0u);
  if (first <= last) walk.rest[walk.level] = nodes_in_range(tree, tree_blocks, box, walk.level, 0u, first, last);
  for (u32 entry; (entry = tree_next(&walk, tree, &arrives)) != NONE;) {
    if (arrives)
      walk.rest[walk.level] = nodes_in_range(tree, tree_blocks, box, walk.level, entry, first, last);
    else
      search_run(s, me, entry, entries_between(entry, 0u, first, last), all, top_level_count(params), finds);
  }
  search_planes_and_trees(s, params, me, finds);
}

// What searches read again and again: the shapes in the order of the tree, and the planes.
kernel void search_tree_gather(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                               global const ShapeInfo* shape_infos, global const Shape* shapes,
                               global const u32* planes, global const u32* top_level_shapes,
                               global const Vec4* positions, global const Vec4* orientations,
                               global const Motion* motions, global const Sleeper* sleepers, global const Bound* bounds,
                               global const u32* tree_items, global real* search_bounds,
                               global SearchInfo* search_infos, global PlaneInfo* plane_infos, global u32* shape_slots,
                               global u32* pair_starts, const StepParams params) {
  const Cell no_cell = {0, 0, 0, NONE};
  FOR_EACH(slot, top_level_count(&params)) {
    const u32 k = tree_items[slot];
    gather_search_info(slot, TOP_LEVEL_SHAPE(k), &bounds[k], no_cell, body_infos, shape_infos, positions, motions,
                       sleepers, search_bounds, search_infos, shape_slots, &params);
  }
  gather_planes(world_ranges, body_infos, shape_infos, shapes, planes, positions, orientations, motions, sleepers,
                plane_infos, pair_starts, &params);
}

kernel void search_tree_search(
    global const WorldRange* world_ranges, global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
    global const Shape* shapes, global const u32* planes, global const WorldTrees* world_trees,
    global const ShapeTree* shape_trees, global const u32* shape_tree_items, global const BoxBlock* shape_tree_blocks,
    global const Vec4* positions, global const Vec4* orientations, global const Motion* motions,
    global const Sleeper* sleepers, global const BoxBlock* tree_blocks, global const real* search_bounds,
    global const SearchInfo* search_infos, global const PlaneInfo* plane_infos, global const u32* joined_starts,
    global const u32* joined_bodies, global u32* found_partners, global u32* pair_starts, const StepParams params) {
  const PairSearch s = PAIR_SEARCH;
  const TreeShape tree = tree_shape(blocks_of(top_level_count(&params)));
  Finds finds = {pair_starts, found_partners, 0, 0u};
  FOR_EACH(slot, top_level_count(&params)) {
    const Searcher me = make_searcher(&s, &params, slot);
    search_nodes(&s, &tree, tree_blocks, &params, &me, &finds);
  }
}

// After the scan of pair_starts.
kernel void search_tree_write(
    global const WorldRange* world_ranges, global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
    global const Shape* shapes, global const u32* planes, global const WorldTrees* world_trees,
    global const ShapeTree* shape_trees, global const u32* shape_tree_items, global const BoxBlock* shape_tree_blocks,
    global const Vec4* positions, global const Vec4* orientations, global const Motion* motions,
    global const Sleeper* sleepers, global const u32* shape_slots, global const BoxBlock* tree_blocks,
    global const real* search_bounds, global const SearchInfo* search_infos, global const PlaneInfo* plane_infos,
    global const u32* joined_starts, global const u32* joined_bodies, global u32* found_partners,
    global const u32* pair_starts, global Pair* pairs, global u32* counters, const StepParams params) {
  const PairSearch s = PAIR_SEARCH;
  const TreeShape tree = tree_shape(blocks_of(top_level_count(&params)));
  const bool full = tell_pairs(pair_starts[params.shapes], counters, &params);
  FOR_EACH(i, full ? 0u : params.shapes) {
    const u32 start = pair_starts[i], count = pair_starts[i + 1u] - start;
    global u32* partners = found_partners + i * FOUND;
    if (count > FOUND) {
      partners = (global u32*)(pairs + start);
      Finds finds = {0, 0, partners, 0u};
      const Searcher me = owner_of_list(&s, &params, shape_slots, i);
      search_nodes(&s, &tree, tree_blocks, &params, &me, &finds);
    }
    write_pairs(i, partners, count, pairs + start);
  }
}
