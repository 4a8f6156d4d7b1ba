#pragma OPENCL FP_CONTRACT OFF
#include "pair_search.h"
#include "types.h"

// All shapes of larger index of the world, place by place: places are in the order of the shapes.
static inline void search_later_shapes(const PairSearch* s, u32 place, StepParams params, Finds* finds) {
  const Searcher me = make_searcher(s, params, place);
  if (!(me.extent > (real)0)) return;
  const WorldRange world = s->world_ranges[me.info.body.world];
  const u32 end = world.first_shape + world.shape_count;
  for (u32 first = place + 1u; first < end; first += LANES) {
    u32 hits = shapes_in_reach(s, &me, first, params.shapes);
    if (end - first < LANES) hits &= (1u << (end - first)) - 1u;
    for (; hits != 0u; hits &= hits - 1u) {
      const PlaceInfo other = s->place_infos[first + lowest_bit(hits)];
      if (!one_looks(me.info.looks, other.looks)) continue;
      if (is_pair(s, me.info.shape, other.shape, me.info.body, other.body)) add_pair(finds, me.info.index, other.index);
    }
  }
  search_planes(s, &me, finds);
}

// One work-group.
kernel void compare_shapes(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                           global const ShapeInfo* shape_infos, global const Shape* shapes, global const u32* planes,
                           global const Vec4* positions, global const Vec4* orientations, global const Motion* motions,
                           global const Sleeper* sleepers, global const Bound* bounds, global real* places,
                           global PlaceInfo* place_infos, global PlaneInfo* plane_infos, global u32* shape_places,
                           global const u32* joined_starts, global const u32* joined_bodies, global u32* found_partners,
                           global u32* pair_starts, global Pair* pairs, global u32* counters, const StepParams params) {
  const Cell no_cell = {0, 0, 0, NONE};
  FOR_EACH(i, params.shapes) {
    gather_place(i, i, no_cell, body_infos, shape_infos, positions, motions, sleepers, bounds, places, place_infos,
                 shape_places, params.shapes, params.bodies);
  }
  gather_planes(world_ranges, body_infos, shape_infos, shapes, planes, positions, orientations, motions, sleepers,
                plane_infos, pair_starts, params);
  barrier(CLK_GLOBAL_MEM_FENCE);

  const PairSearch s = {world_ranges, body_infos,  shape_infos, planes,        positions,    motions,
                        places,       place_infos, plane_infos, joined_starts, joined_bodies};
  Finds finds = {pair_starts, found_partners, 0, 0u};
  FOR_EACH(place, params.shapes) { search_later_shapes(&s, place, params, &finds); }
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

  const bool full = tell_pairs(pair_starts[params.shapes], counters, params);
  FOR_EACH(i, full ? 0u : params.shapes) {
    const u32 start = pair_starts[i], count = pair_starts[i + 1u] - start;
    global u32* partners = found_partners + i * FOUND;
    if (count > FOUND) {
      partners = (global u32*)(pairs + start);
      Finds all = {0, 0, partners, 0u};
      search_later_shapes(&s, i, params, &all);
    }
    write_pairs(i, partners, count, pairs + start);
  }
}
