#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "grid.h"
#include "lanes.h"
#include "shapes/reach.h"
#include "shapes/sphere_plane.h"
#include "sort.h"
#include "types.h"

// Partners of a shape that the first search keeps; where there are more, the shape searches for all of its own.
#define FOUND 16u

// The spheres of the grid in the order of their buckets, one array a component: what the pair test needs of them.
// Arrays are PACK longer than there are shapes, so that all lanes can read.
enum GridSphere { GRID_X, GRID_Y, GRID_Z, GRID_RADIUS, GRID_VX, GRID_VY, GRID_VZ };
#define GRID_SPHERE(component, shapes) ((u32)(component) * ((shapes) + PACK))

// What else is known of a sphere of the grid, on one line.
typedef struct GridInfo {
  ShapeInfo shape;
  BodyInfo body;
  u32 index;
  i32 cell_y, cell_z;
  u32 pad;
} GridInfo;

// A plane in the world. What is farther from it than `slack` times what a sphere can come in the step is out of reach.
typedef struct GridPlane {
  real point[3], normal[3];
  real slack, pad;
} GridPlane;

// What a search reads.
typedef struct PairSearch {
  global const WorldRange* world_ranges;
  global const BodyInfo* body_infos;
  global const ShapeInfo* shape_infos;
  global const u32* planes;
  global const Vec4* positions;
  global const Motion* motions;
  global const Vec4* bounds;
  global const u32* bucket_starts;
  global const real* grid_spheres;
  global const GridInfo* grid_infos;
  global const GridPlane* grid_planes;
  u32 max_extent;  // bits
} PairSearch;

// The sphere that looks for others.
typedef struct Searcher {
  GridInfo info;
  Vec3 center, velocity;
  real radius, extent, margin, h;
  u32 span;                                         // buckets of a row of cells
  i32 low_x, high_x, low_y, high_y, low_z, high_z;  // cells in reach
} Searcher;

// Where a search puts what it finds. In the first one each pair is found once, from either side, and given to its
// owner: counts[owner] and the first FOUND of found[owner]. In the second one a sphere fills the list of its own
// partners.
typedef struct Finds {
  global u32* counts;
  global u32* found;
  global u32* list;  // 0 in the first search
  u32 length;
} Finds;

static inline void add_pair(Finds* finds, u32 owner, u32 partner) {
  if (finds->list) {
    finds->list[finds->length++] = partner;
  } else {
    const u32 slot = atomic_inc(&finds->counts[owner]);
    if (slot < FOUND) finds->found[owner * FOUND + slot] = partner;
  }
}

static inline Vec3 search_position(const PairSearch* s, u32 body) {
  const Vec4 position = s->positions[body];
  return make3(position.x, position.y, position.z);
}

static inline Searcher make_searcher(const PairSearch* s, StepParams params, u32 place) {
  global const real* mine = s->grid_spheres + place;
  Searcher me;
  me.info = s->grid_infos[place];
  me.extent = s->bounds[me.info.index].w;
  me.margin = params.margin;
  me.h = step_length(params);
  const real size = cell_size(params, s->max_extent);
  const real reach = pair_reach(params, me.extent, s->max_extent);
  me.center = make3(mine[GRID_SPHERE(GRID_X, params.shapes)], mine[GRID_SPHERE(GRID_Y, params.shapes)],
                    mine[GRID_SPHERE(GRID_Z, params.shapes)]);
  me.velocity = make3(mine[GRID_SPHERE(GRID_VX, params.shapes)], mine[GRID_SPHERE(GRID_VY, params.shapes)],
                      mine[GRID_SPHERE(GRID_VZ, params.shapes)]);
  me.radius = mine[GRID_SPHERE(GRID_RADIUS, params.shapes)];
  me.low_x = cell_of(me.center.x - reach, size);
  me.high_x = cell_of(me.center.x + reach, size);
  me.low_y = cell_of(me.center.y - reach, size);
  me.high_y = cell_of(me.center.y + reach, size);
  me.low_z = cell_of(me.center.z - reach, size);
  me.high_z = cell_of(me.center.z + reach, size);
  const u32 length = (u32)(me.high_x - me.low_x) + 1u;
  me.span = length < params.buckets ? length : params.buckets;
  return me;
}

// Bit k is set where the sphere at `place` + k of the grid is in reach.
static inline u32 spheres_in_reach(const PairSearch* s, const Searcher* me, u32 place, u32 shapes) {
  global const real* other = s->grid_spheres + place;
  const Lane3 center =
      lane_make3(LANE_LOAD(other + GRID_SPHERE(GRID_X, shapes)), LANE_LOAD(other + GRID_SPHERE(GRID_Y, shapes)),
                 LANE_LOAD(other + GRID_SPHERE(GRID_Z, shapes)));
  const Lane3 velocity =
      lane_make3(LANE_LOAD(other + GRID_SPHERE(GRID_VX, shapes)), LANE_LOAD(other + GRID_SPHERE(GRID_VY, shapes)),
                 LANE_LOAD(other + GRID_SPHERE(GRID_VZ, shapes)));
  const lane radius = LANE_LOAD(other + GRID_SPHERE(GRID_RADIUS, shapes));
  const Lane3 d = lane_make3(me->center.x - center.x, me->center.y - center.y, me->center.z - center.z);
  const Lane3 u = lane_make3(me->velocity.x - velocity.x, me->velocity.y - velocity.y, me->velocity.z - velocity.z);
  const lane gap = sqrt(lane_dot3(d, d)) - me->radius - radius;
  const lane speed = sqrt(lane_dot3(u, u));
  return LANE_BITS(gap <= me->margin + me->h * speed);
}

// The buckets of a row of cells are one piece of the list, or two where they run over the end of the table. `later`:
// find only spheres of larger index.
static inline void search_row(const PairSearch* s, const Searcher* me, i32 y, i32 z, bool later, StepParams params,
                              Finds* finds) {
  const u32 first = bucket_of(me->low_x, row_hash(y, z, me->info.body.world), params.buckets);
  const u32 past = first + me->span;
  u32 place = s->bucket_starts[first];
  u32 end = s->bucket_starts[past < params.buckets ? past : params.buckets];
  u32 wrapped = past > params.buckets ? s->bucket_starts[past - params.buckets] : 0u;
  for (;;) {
    for (; place < end; place += LANES) {
      u32 hits = spheres_in_reach(s, me, place, params.shapes);
      if (end - place < LANES) hits &= (1u << (end - place)) - 1u;
      for (; hits != 0u; hits &= hits - 1u) {
        const GridInfo other = s->grid_infos[place + 31u - clz(hits & -hits)];
        // other rows may share the buckets of this one
        if (other.cell_y != y || other.cell_z != z || (later && other.index <= me->info.index)) continue;
        if (!may_touch(me->info.shape, other.shape, me->info.body, other.body)) continue;
        const bool mine = me->info.index < other.index;
        add_pair(finds, mine ? me->info.index : other.index, mine ? other.index : me->info.index);
      }
    }
    if (wrapped == 0u) return;
    place = 0u;
    end = wrapped;
    wrapped = 0u;
  }
}

static inline void search_planes(const PairSearch* s, const Searcher* me, Finds* finds) {
  const WorldRange world = s->world_ranges[me->info.body.world];
  for (u32 k = world.first_plane; k < world.first_plane + world.plane_count; ++k) {
    const GridPlane plane = s->grid_planes[k];
    const Vec3 point = make3(plane.point[0], plane.point[1], plane.point[2]);
    const Vec3 normal = make3(plane.normal[0], plane.normal[1], plane.normal[2]);
    const real gap = dot3(normal, sub3(me->center, point)) - me->radius;
    const u32 j = s->planes[k];
    if (gap + me->radius > plane.slack * (me->extent + me->margin)) continue;
    const ShapeInfo other = s->shape_infos[j];
    const u32 body_a = me->info.shape.body, body_b = other.body;
    if (!may_touch(me->info.shape, other, me->info.body, s->body_infos[body_b])) continue;
    const Vec3 touch = sub3(me->center, scale3(me->radius, normal));
    const real speed = approach_speed(normal, &s->motions[body_a], sub3(touch, search_position(s, body_a)),
                                      &s->motions[body_b], sub3(touch, search_position(s, body_b)));
    if (gap <= me->margin + me->h * speed) add_pair(finds, me->info.index, j);
  }
}

// The first search looks at its own row and the rows behind it: who is before has this sphere behind itself.
static inline void search_pairs(const PairSearch* s, StepParams params, u32 place, Finds* finds) {
  const Searcher me = make_searcher(s, params, place);
  const bool all = finds->list != 0;
  for (i32 z = all ? me.low_z : me.info.cell_z; z <= me.high_z; ++z) {
    const bool own_layer = z == me.info.cell_z;
    for (i32 y = own_layer && !all ? me.info.cell_y : me.low_y; y <= me.high_y; ++y)
      search_row(s, &me, y, z, all || (own_layer && y == me.info.cell_y), params, finds);
  }
  search_planes(s, &me, finds);
}

// What searches read again and again: the spheres in the order of their buckets, and the planes.
kernel void find_pairs_gather(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                              global const ShapeInfo* shape_infos, global const Shape* shapes, global const u32* planes,
                              global const Vec4* positions, global const Vec4* orientations,
                              global const Motion* motions, global const Vec4* bounds, global const Cell* cells,
                              global const u32* bucket_items, global real* grid_spheres, global GridInfo* grid_infos,
                              global GridPlane* grid_planes, global u32* pair_starts, const StepParams params) {
  FOR_EACH(place, params.shapes) {
    const u32 i = bucket_items[place];
    if (i == NONE) continue;
    const u32 body = shape_infos[i].body;
    const Vec3 center = make3(bounds[i].x, bounds[i].y, bounds[i].z);
    const Vec3 position = make3(positions[body].x, positions[body].y, positions[body].z);
    const Vec3 velocity = point_velocity(&motions[body], sub3(center, position));
    global real* mine = grid_spheres + place;
    mine[GRID_SPHERE(GRID_X, params.shapes)] = center.x;
    mine[GRID_SPHERE(GRID_Y, params.shapes)] = center.y;
    mine[GRID_SPHERE(GRID_Z, params.shapes)] = center.z;
    mine[GRID_SPHERE(GRID_RADIUS, params.shapes)] = shapes[i].reach;
    mine[GRID_SPHERE(GRID_VX, params.shapes)] = velocity.x;
    mine[GRID_SPHERE(GRID_VY, params.shapes)] = velocity.y;
    mine[GRID_SPHERE(GRID_VZ, params.shapes)] = velocity.z;
    GridInfo info;
    info.shape = shape_infos[i];
    info.body = body_infos[body];
    info.index = i;
    info.cell_y = cells[i].y;
    info.cell_z = cells[i].z;
    info.pad = 0u;
    grid_infos[place] = info;
  }
  FOR_EACH(w, params.worlds) {
    const WorldRange world = world_ranges[w];
    for (u32 k = world.first_plane; k < world.first_plane + world.plane_count; ++k) {
      const u32 body = shape_infos[planes[k]].body;
      const Pose pose = make_pose(positions[body], orientations[body]);
      const Vec3 point = shape_center(pose, &shapes[planes[k]]);
      const Vec3 normal = plane_normal(shape_rotation(pose, &shapes[planes[k]]));
      const Vec3 v = make3(motions[body].v[0], motions[body].v[1], motions[body].v[2]);
      const Vec3 spin = make3(motions[body].w[0], motions[body].w[1], motions[body].w[2]);
      const bool still = dot3(v, v) + dot3(spin, spin) == (real)0;
      const GridPlane plane = {
          {point.x, point.y, point.z}, {normal.x, normal.y, normal.z}, still ? (real)1.001 : (real)1e30, (real)0};
      grid_planes[k] = plane;
    }
  }
  FOR_EACH(i, params.shapes + 1u) { pair_starts[i] = 0u; }
}

kernel void find_pairs_search(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                              global const ShapeInfo* shape_infos, global const u32* planes,
                              global const Vec4* positions, global const Motion* motions, global const Vec4* bounds,
                              global const u32* bucket_starts, global const u32* bucket_items,
                              global const real* grid_spheres, global const GridInfo* grid_infos,
                              global const GridPlane* grid_planes, global u32* found_partners, global u32* pair_starts,
                              global const u32* counters, const StepParams params) {
  const PairSearch s = {world_ranges, body_infos, shape_infos, planes,
                        positions,    motions,    bounds,      bucket_starts,
                        grid_spheres, grid_infos, grid_planes, counters[COUNTER_MAX_EXTENT]};
  Finds finds = {pair_starts, found_partners, 0, 0u};
  FOR_EACH(place, params.shapes) {
    if (bucket_items[place] != NONE) search_pairs(&s, params, place, &finds);
  }
}

// After the scan of pair_starts.
kernel void find_pairs_write(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                             global const ShapeInfo* shape_infos, global const u32* planes,
                             global const Vec4* positions, global const Motion* motions, global const Vec4* bounds,
                             global const u32* bucket_starts, global const u32* bucket_items,
                             global const real* grid_spheres, global const GridInfo* grid_infos,
                             global const GridPlane* grid_planes, global u32* found_partners,
                             global const u32* pair_starts, global Pair* pairs, global u32* counters,
                             const StepParams params) {
  const PairSearch s = {world_ranges, body_infos, shape_infos, planes,
                        positions,    motions,    bounds,      bucket_starts,
                        grid_spheres, grid_infos, grid_planes, counters[COUNTER_MAX_EXTENT]};
  const u32 total = pair_starts[params.shapes];
  const bool full = total > params.pair_capacity;
  if (get_global_id(0) == 0) {
    counters[COUNTER_PAIRS_NEEDED] = total;
    counters[COUNTER_PAIRS] = full ? 0u : total;
    if (full) counters[COUNTER_STATUS] |= STATUS_PAIRS_FULL;
  }
  FOR_EACH(place, full ? 0u : params.shapes) {
    const u32 i = bucket_items[place];
    if (i == NONE) continue;
    const u32 start = pair_starts[i], count = pair_starts[i + 1u] - start;
    global u32* partners = found_partners + i * FOUND;
    if (count > FOUND) {
      // the list comes to lie in the first half of the slots; from behind, each partner moves to its own
      partners = (global u32*)(pairs + start);
      Finds finds = {0, 0, partners, 0u};
      search_pairs(&s, params, place, &finds);
    }
    sort_ascending(partners, count);
    for (u32 k = count; k > 0u; --k) {
      const u32 partner = partners[k - 1u];
      pairs[start + k - 1u].shape_a = i;
      pairs[start + k - 1u].shape_b = partner;
    }
  }
}
