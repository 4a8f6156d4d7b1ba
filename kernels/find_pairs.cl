#pragma OPENCL FP_CONTRACT OFF
#include "pair_search.h"
#include "shape_trees.h"
#include "types.h"

// The cells in range of a shape: a row of them has buckets in a row.
typedef struct CellWindow {
  i32 low_x, high_x, low_y, high_y, low_z, high_z;
  u32 span;  // buckets of a row
} CellWindow;

static inline CellWindow make_window(const Searcher* me, u32 max_extent, const StepParams* params) {
  const real size = cell_size(max_extent);
  const real range = pair_range(me->extent, max_extent);
  CellWindow window;
  window.low_x = cell_of(me->center.x - range, size);
  window.high_x = cell_of(me->center.x + range, size);
  window.low_y = cell_of(me->center.y - range, size);
  window.high_y = cell_of(me->center.y + range, size);
  window.low_z = cell_of(me->center.z - range, size);
  window.high_z = cell_of(me->center.z + range, size);
  const u32 length = (u32)(window.high_x - window.low_x) + 1u;
  window.span = length < params->buckets ? length : params->buckets;
  return window;
}

// Which shapes of a row a search finds; of the first search those that are sought are always among them.
enum RowSearch { ROW_ALL, ROW_LATER, ROW_SOUGHT };  // all, those of larger index, no others

// The buckets of a row of cells are one piece of the list, or two where they run over the end of the table.
static inline void search_row(const PairSearch* s, const Searcher* me, const CellWindow* window, i32 y, i32 z,
                              u32 which, global const u32* bucket_starts, const StepParams* params, Finds* finds) {
  const u32 first = bucket_of(window->low_x, row_hash(y, z, me->info.body.world), params->buckets);
  const u32 past = first + window->span;
  u32 slot = bucket_starts[first];
  u32 end = bucket_starts[past < params->buckets ? past : params->buckets];
  u32 wrapped = past > params->buckets ? bucket_starts[past - params->buckets] : 0u;
  for (;;) {
    for (; slot < end; slot += LANES) {
      u32 hits = shapes_in_range(s, me, slot, top_level_count(params));
      if (end - slot < LANES) hits &= (1u << (end - slot)) - 1u;
      for (; hits != 0u; hits &= hits - 1u) {
        const SearchInfo other = s->search_infos[slot + lowest_bit(hits)];
        // other rows may share the buckets of this one
        if (other.cell_y != y || other.cell_z != z) continue;
        const bool later = other.index > me->info.index, sought = finds->list == 0 && is_sought(&other);
        if (!sought && (which == ROW_SOUGHT || (which == ROW_LATER && !later))) continue;
        if (!one_looks(me->info.looks, other.looks)) continue;
        if (!is_pair(s, me->info.shape, other.shape, me->info.body, other.body)) continue;
        add_pair(finds, later ? me->info.index : other.index, later ? other.index : me->info.index);
      }
    }
    if (wrapped == 0u) return;
    slot = 0u;
    end = wrapped;
    wrapped = 0u;
  }
}

// The first search looks at its own row and the rows behind it: who is before has this shape behind itself.
static inline void search_cells(const PairSearch* s, const StepParams* params, const Searcher* me,
                                global const u32* bucket_starts, u32 max_extent, Finds* finds) {
  const bool all = finds->list != 0, around = all || SEARCHES_AROUND;
  if (!all && is_sought(&me->info)) {
    if (FEATURE_SLEEPING) search_planes_and_trees(s, params, me, finds);  // some may move
    return;
  }
  const CellWindow window = make_window(me, max_extent, params);
  for (i32 z = around ? window.low_z : me->info.cell_z; z <= window.high_z; ++z) {
    const bool own_layer = z == me->info.cell_z;
    for (i32 y = own_layer && !around ? me->info.cell_y : window.low_y; y <= window.high_y; ++y) {
      const bool before = z < me->info.cell_z || (own_layer && y < me->info.cell_y);
      const bool in_list = all || (own_layer && y == me->info.cell_y);
      search_row(s, me, &window, y, z,
                 in_list  ? ROW_LATER
                 : before ? ROW_SOUGHT
                          : ROW_ALL,
                 bucket_starts, params, finds);
    }
  }
  search_planes_and_trees(s, params, me, finds);
}

// What searches read again and again: the shapes in the order of their buckets, and the planes.
kernel void find_pairs_gather(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                              global const ShapeInfo* shape_infos, global const Shape* shapes, global const u32* planes,
                              global const u32* top_level_shapes, global const Vec4* positions,
                              global const Vec4* orientations, global const Motion* motions,
                              global const Sleeper* sleepers, global const Bound* bounds, global const Cell* cells,
                              global const u32* bucket_items, global real* search_bounds,
                              global SearchInfo* search_infos, global PlaneInfo* plane_infos, global u32* shape_slots,
                              global u32* pair_starts, const StepParams params) {
  FOR_EACH(slot, top_level_count(&params)) {
    const u32 k = bucket_items[slot];
    if (k == NONE) continue;
    gather_search_info(slot, TOP_LEVEL_SHAPE(k), &bounds[k], cells[k], body_infos, shape_infos, positions, motions,
                       sleepers, search_bounds, search_infos, shape_slots, &params);
  }
  gather_planes(world_ranges, body_infos, shape_infos, shapes, planes, positions, orientations, motions, sleepers,
                plane_infos, pair_starts, &params);
}

kernel void find_pairs_search(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                              global const ShapeInfo* shape_infos, global const Shape* shapes, global const u32* planes,
                              global const WorldTrees* world_trees, global const ShapeTree* shape_trees,
                              global const u32* shape_tree_items, global const BoxBlock* shape_tree_blocks,
                              global const Vec4* positions, global const Vec4* orientations,
                              global const Motion* motions, global const Sleeper* sleepers,
                              global const u32* bucket_starts, global const u32* bucket_items,
                              global const real* search_bounds, global const SearchInfo* search_infos,
                              global const PlaneInfo* plane_infos, global const u32* joined_starts,
                              global const u32* joined_bodies, global u32* found_partners, global u32* pair_starts,
                              global const u32* counters, const StepParams params) {
  const PairSearch s = PAIR_SEARCH;
  Finds finds = {pair_starts, found_partners, 0, 0u};
  FOR_EACH(slot, top_level_count(&params)) {
    if (bucket_items[slot] == NONE) continue;
    const Searcher me = make_searcher(&s, &params, slot);
    search_cells(&s, &params, &me, bucket_starts, counters[COUNTER_MAX_EXTENT], &finds);
  }
}

// After the scan of pair_starts.
kernel void find_pairs_write(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                             global const ShapeInfo* shape_infos, global const Shape* shapes, global const u32* planes,
                             global const WorldTrees* world_trees, global const ShapeTree* shape_trees,
                             global const u32* shape_tree_items, global const BoxBlock* shape_tree_blocks,
                             global const Vec4* positions, global const Vec4* orientations,
                             global const Motion* motions, global const Sleeper* sleepers,
                             global const u32* bucket_starts, global const u32* shape_slots,
                             global const real* search_bounds, global const SearchInfo* search_infos,
                             global const PlaneInfo* plane_infos, global const u32* joined_starts,
                             global const u32* joined_bodies, global u32* found_partners, global const u32* pair_starts,
                             global Pair* pairs, global u32* counters, const StepParams params) {
  const PairSearch s = PAIR_SEARCH;
  const bool full = tell_pairs(pair_starts[params.shapes], counters, &params);
  FOR_EACH(i, full ? 0u : params.shapes) {
    const u32 start = pair_starts[i], count = pair_starts[i + 1u] - start;
    global u32* partners = found_partners + i * FOUND;
    if (count > FOUND) {
      partners = (global u32*)(pairs + start);
      Finds finds = {0, 0, partners, 0u};
      const Searcher me = owner_of_list(&s, &params, shape_slots, i);
      search_cells(&s, &params, &me, bucket_starts, counters[COUNTER_MAX_EXTENT], &finds);
    }
    write_pairs(i, partners, count, pairs + start);
  }
}
