#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "grid.h"
#include "shapes/pairs.h"
#include "shapes/reach.h"
#include "sort.h"
#include "types.h"

// Partners of one shape that the first search keeps; a shape with more is searched a second time.
#define FOUND 16u

// What a search reads.
typedef struct PairSearch {
  global const WorldRange* world_ranges;
  global const BodyInfo* body_infos;
  global const ShapeInfo* shape_infos;
  global const Shape* shapes;
  global const u32* planes;
  global const Vec4* positions;
  global const Vec4* orientations;
  global const Motion* motions;
  global const Vec4* bounds;
  global const Cell* cells;
  global const u32* bucket_starts;
  global const u32* bucket_items;
  u32 max_extent;  // bits
} PairSearch;

static inline Vec3 bound_center(const PairSearch* s, u32 shape) {
  const Vec4 bound = s->bounds[shape];
  return make3(bound.x, bound.y, bound.z);
}

static inline Vec3 body_position(const PairSearch* s, u32 body) {
  const Vec4 position = s->positions[body];
  return make3(position.x, position.y, position.z);
}

static inline bool is_pair(const PairSearch* s, u32 i, u32 j) {
  const ShapeInfo a = s->shape_infos[i], c = s->shape_infos[j];
  return may_touch(a, c, s->body_infos[a.body], s->body_infos[c.body]);
}

static inline bool spheres_in_reach(const PairSearch* s, StepParams params, u32 i, u32 j) {
  const Vec3 center_i = bound_center(s, i), center_j = bound_center(s, j);
  const u32 body_i = s->shape_infos[i].body, body_j = s->shape_infos[j].body;
  const Vec3 velocity_i = point_velocity(&s->motions[body_i], sub3(center_i, body_position(s, body_i)));
  const Vec3 velocity_j = point_velocity(&s->motions[body_j], sub3(center_j, body_position(s, body_j)));
  const real gap = length3(sub3(center_i, center_j)) - s->shapes[i].size[0] - s->shapes[j].size[0];
  return within_reach(params, gap, length3(sub3(velocity_i, velocity_j)));
}

static inline bool plane_in_reach(const PairSearch* s, StepParams params, u32 i, u32 plane) {
  const u32 body_i = s->shape_infos[i].body, body_p = s->shape_infos[plane].body;
  const Touch touch =
      sphere_plane(place_shape(make_pose(s->positions[body_i], s->orientations[body_i]), s->shapes[i]),
                   place_shape(make_pose(s->positions[body_p], s->orientations[body_p]), s->shapes[plane]));
  const real speed = approach_speed(touch, &s->motions[body_i], body_position(s, body_i), &s->motions[body_p],
                                    body_position(s, body_p));
  return within_reach(params, touch.gap, speed);
}

// The bounds of a pair overlap: less than the pair test asks for, and cheap. The factor covers rounding.
static inline bool bounds_overlap(Vec4 a, Vec4 b, real margin) {
  const Vec3 d = make3(a.x - b.x, a.y - b.y, a.z - b.z);
  const real reach = a.w + b.w + margin;
  return !(dot3(d, d) > reach * reach * (real)1.0001);
}

// Puts the first `room` partners of sphere i into the list and returns how many there are.
static inline u32 search_grid(const PairSearch* s, StepParams params, u32 i, global u32* list, u32 room) {
  const real size = cell_size(params, s->max_extent);
  const Vec4 bound = s->bounds[i];
  const real reach = pair_reach(params, bound.w, s->max_extent);
  const u32 world = s->body_infos[s->shape_infos[i].body].world;
  const i32 low_x = cell_of(bound.x - reach, size), high_x = cell_of(bound.x + reach, size);
  const i32 low_y = cell_of(bound.y - reach, size), high_y = cell_of(bound.y + reach, size);
  const i32 low_z = cell_of(bound.z - reach, size), high_z = cell_of(bound.z + reach, size);
  const u32 length = (u32)(high_x - low_x) + 1u;
  const u32 span = length < params.buckets ? length : params.buckets;
  u32 count = 0u;
  for (i32 z = low_z; z <= high_z; ++z) {
    for (i32 y = low_y; y <= high_y; ++y) {
      // the row's buckets are one list, or two where they run over the end of the table
      const u32 first = bucket_of(low_x, row_hash(y, z, world), params.buckets);
      const u32 past = first + span;
      const u32 begin = s->bucket_starts[first];
      const u32 straight = s->bucket_starts[past < params.buckets ? past : params.buckets] - begin;
      const u32 wrapped = past > params.buckets ? s->bucket_starts[past - params.buckets] : 0u;
      for (u32 n = 0u; n < straight + wrapped; ++n) {
        const u32 j = s->bucket_items[n < straight ? begin + n : n - straight];
        if (j <= i || !bounds_overlap(bound, s->bounds[j], params.margin)) continue;
        const Cell cell = s->cells[j];
        const bool in_row = cell.y == y && cell.z == z && cell.x >= low_x && cell.x <= high_x;
        if (!in_row || !is_pair(s, i, j) || !spheres_in_reach(s, params, i, j)) continue;
        if (count < room) list[count] = j;
        ++count;
      }
    }
  }
  return count;
}

static inline u32 search_planes(const PairSearch* s, StepParams params, u32 i, global u32* list, u32 count, u32 room) {
  const WorldRange world = s->world_ranges[s->body_infos[s->shape_infos[i].body].world];
  for (u32 k = 0u; k < world.plane_count; ++k) {
    const u32 plane = s->planes[world.first_plane + k];
    if (!is_pair(s, i, plane) || !plane_in_reach(s, params, i, plane)) continue;
    if (count < room) list[count] = plane;
    ++count;
  }
  return count;
}

static inline u32 find_partners(const PairSearch* s, StepParams params, u32 i, global u32* list, u32 room) {
  if (s->cells[i].bucket == NONE) return 0u;
  const u32 spheres = search_grid(s, params, i, list, room);
  const u32 count = search_planes(s, params, i, list, spheres, room);
  if (count <= room) sort_ascending(list, count);
  return count;
}

kernel void find_pairs_count(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                             global const ShapeInfo* shape_infos, global const Shape* shapes, global const u32* planes,
                             global const Vec4* positions, global const Vec4* orientations,
                             global const Motion* motions, global const Vec4* bounds, global const Cell* cells,
                             global const u32* bucket_starts, global const u32* bucket_items,
                             global u32* found_partners, global u32* pair_starts, global const u32* counters,
                             const StepParams params) {
  const PairSearch s = {world_ranges,
                        body_infos,
                        shape_infos,
                        shapes,
                        planes,
                        positions,
                        orientations,
                        motions,
                        bounds,
                        cells,
                        bucket_starts,
                        bucket_items,
                        counters[COUNTER_MAX_EXTENT]};
  FOR_EACH(i, params.shapes + 1u) {
    pair_starts[i] = i < params.shapes ? find_partners(&s, params, i, found_partners + i * FOUND, FOUND) : 0u;
  }
}

// After the scan of pair_starts.
kernel void find_pairs_write(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                             global const ShapeInfo* shape_infos, global const Shape* shapes, global const u32* planes,
                             global const Vec4* positions, global const Vec4* orientations,
                             global const Motion* motions, global const Vec4* bounds, global const Cell* cells,
                             global const u32* bucket_starts, global const u32* bucket_items,
                             global const u32* found_partners, global const u32* pair_starts, global Pair* pairs,
                             global u32* counters, const StepParams params) {
  const PairSearch s = {world_ranges,
                        body_infos,
                        shape_infos,
                        shapes,
                        planes,
                        positions,
                        orientations,
                        motions,
                        bounds,
                        cells,
                        bucket_starts,
                        bucket_items,
                        counters[COUNTER_MAX_EXTENT]};
  const u32 total = pair_starts[params.shapes];
  const bool full = total > params.pair_capacity;
  if (get_global_id(0) == 0) {
    counters[COUNTER_PAIRS_NEEDED] = total;
    counters[COUNTER_PAIRS] = full ? 0u : total;
    if (full) counters[COUNTER_STATUS] |= STATUS_PAIRS_FULL;
  }
  FOR_EACH(i, full ? 0u : params.shapes) {
    const u32 start = pair_starts[i], count = pair_starts[i + 1u] - start;
    if (count <= FOUND) {
      for (u32 k = 0u; k < count; ++k) {
        pairs[start + k].shape_a = i;
        pairs[start + k].shape_b = found_partners[i * FOUND + k];
      }
    } else {
      // the list comes to lie in the first half of its slots; from behind, each partner moves to its own
      global u32* list = (global u32*)(pairs + start);
      find_partners(&s, params, i, list, count);
      for (u32 k = count; k > 0u; --k) {
        const u32 partner = list[k - 1u];
        pairs[start + k - 1u].shape_a = i;
        pairs[start + k - 1u].shape_b = partner;
      }
    }
  }
}
