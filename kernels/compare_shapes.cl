#pragma OPENCL FP_CONTRACT OFF
#include "pair_search.h"
#include "shape_trees.h"
#include "types.h"

// All top-level shapes of larger index of the world, slot by slot: slots are in the order of the shapes.
static inline void search_later_shapes(const PairSearch* s, const Searcher* me, const StepParams* params,
                                       Finds* finds) {
  if (!(me->extent > (real)0)) return;
  const TopLevelRange world = top_level_range(me->info.body.world, s->world_ranges, s->world_trees);
  const u32 end = world.first + world.count;
  for (u32 first = me->slot == NONE ? world.first : me->slot + 1u; first < end; first += LANES) {
    u32 hits = shapes_in_range(s, me, first, top_level_count(params));
    if (end - first < LANES) hits &= (1u << (end - first)) - 1u;
    for (; hits != 0u; hits &= hits - 1u) {
      const SearchInfo other = s->search_infos[first + lowest_bit(hits)];
      if (other.index < me->info.index) continue;  // those in trees have no slot among the others
      if (!one_looks(me->info.looks, other.looks)) continue;
      if (!is_pair(s, me->info.shape, other.shape, me->info.body, other.body)) continue;
      add_pair(finds, me->info.index, other.index);
    }
  }
  search_planes_and_trees(s, params, me, finds);
}

// One work-group.
kernel void compare_shapes(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                           global const ShapeInfo* shape_infos, global const Shape* shapes, global const u32* planes,
                           global const u32* top_level_shapes, global const WorldTrees* world_trees,
                           global const ShapeTree* shape_trees, global const u32* shape_tree_items,
                           global const BoxBlock* shape_tree_blocks, global const Vec4* positions,
                           global const Vec4* orientations, global const Motion* motions,
                           global const Sleeper* sleepers, global const Bound* bounds, global real* search_bounds,
                           global SearchInfo* search_infos, global PlaneInfo* plane_infos, global u32* shape_slots,
                           global const u32* joined_starts, global const u32* joined_bodies, global u32* found_partners,
                           global u32* pair_starts, global Pair* pairs, global u32* counters, const StepParams params) {
  const Cell no_cell = {0, 0, 0, NONE};
  FOR_EACH(k, top_level_count(&params)) {
    gather_search_info(k, TOP_LEVEL_SHAPE(k), &bounds[k], no_cell, body_infos, shape_infos, positions, motions,
                       sleepers, search_bounds, search_infos, shape_slots, &params);
  }
  gather_planes(world_ranges, body_infos, shape_infos, shapes, planes, positions, orientations, motions, sleepers,
                plane_infos, pair_starts, &params);
  barrier(CLK_GLOBAL_MEM_FENCE);

  const PairSearch s = PAIR_SEARCH;
  Finds finds = {pair_starts, found_partners, 0, 0u};
  FOR_EACH(slot, top_level_count(&params)) {
    const Searcher me = make_searcher(&s, &params, slot);
    search_later_shapes(&s, &me, &params, &finds);
  }
  barrier(CLK_GLOBAL_MEM_FENCE);

  if (get_local_id(0) == 0) {
    u32 sum = 0u;
    for (u32 i = 0u; i <= params.shapes; ++i) {
      const u32 count = pair_starts[i];
      pair_starts[i] = sum;
      sum += count;
    }
  }
  barrier(CLK_GLOBAL_MEM_FENCE);

  const bool full = tell_pairs(pair_starts[params.shapes], counters, &params);
  FOR_EACH(i, full ? 0u : params.shapes) {
    const u32 start = pair_starts[i], count = pair_starts[i + 1u] - start;
    global u32* partners = found_partners + i * FOUND;
    if (count > FOUND) {
      partners = (global u32*)(pairs + start);
      Finds all = {0, 0, partners, 0u};
      const Searcher me = owner_of_list(&s, &params, shape_slots, i);
      search_later_shapes(&s, &me, &params, &all);
    }
    write_pairs(i, partners, count, pairs + start);
  }
}
