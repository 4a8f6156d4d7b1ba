// What the searches of the broad phase share: the test of a pair, the planes, and the lists that pairs go to.
// cpu_reference/pair_test.hpp is the twin and gives the formulas.
#ifndef LOCKSTEP_PAIR_SEARCH_H
#define LOCKSTEP_PAIR_SEARCH_H

#include "common.h"
#include "grid.h"
#include "lanes.h"
#include "shape_bound.h"
#include "shapes/may_touch.h"
#include "shapes/sphere_plane.h"
#include "sleep.h"
#include "sort.h"
#include "top_level_shapes.h"

// Partners of a shape that the first search keeps; where there are more, the shape searches for all of its own.
#define FOUND 16u

// The top-level shapes in the order in which a search meets them, one array a component: what the test needs of them.
// Arrays are PACK longer than there are shapes, so that all lanes can read. Two shapes that are both ROUND are spheres.
enum SearchComponent {
  SEARCH_X,
  SEARCH_Y,
  SEARCH_Z,
  SEARCH_BOUNDING_RADIUS,
  SEARCH_EXTENT,
  SEARCH_VX,
  SEARCH_VY,
  SEARCH_VZ,
  SEARCH_BOX_X,
  SEARCH_BOX_Y,
  SEARCH_BOX_Z,
  SEARCH_ROTATIONAL_SPEED,
  SEARCH_ROUND
};
#define SEARCH_ARRAY(component, count) ((u32)(component) * ((count) + PACK))

// What else is known of the shape in a slot, on one line.
typedef struct SearchInfo {
  ShapeInfo shape;
  BodyInfo body;
  u32 index;
  i32 cell_y, cell_z;  // of the grid
  u32 looks;           // 1 where it looks for others, 0 where it is only sought
} SearchInfo;

// A plane in the world. What is farther from it than `slack` times what a shape can come in the step is out of range.
typedef struct PlaneInfo {
  real point[3], normal[3];
  real slack;
  u32 looks;
} PlaneInfo;

// What every search reads.
typedef struct PairSearch {
  global const WorldRange* world_ranges;
  global const BodyInfo* body_infos;
  global const ShapeInfo* shape_infos;
  global const Shape* shapes;
  global const u32* planes;
  global const WorldTrees* world_trees;
  global const ShapeTree* shape_trees;
  global const u32* shape_tree_items;
  global const BoxBlock* shape_tree_blocks;
  global const Vec4* positions;
  global const Vec4* orientations;
  global const Motion* motions;
  global const Sleeper* sleepers;
  global const real* search_bounds;
  global const SearchInfo* search_infos;
  global const PlaneInfo* plane_infos;
  global const u32* joined_starts;
  global const u32* joined_bodies;
} PairSearch;

// Of the parameters of a kernel, which are called as the buffers are.
#define PAIR_SEARCH                                                                                              \
  {                                                                                                              \
    world_ranges, body_infos, shape_infos, shapes, planes, world_trees, shape_trees, shape_tree_items,           \
        shape_tree_blocks, positions, orientations, motions, sleepers, search_bounds, search_infos, plane_infos, \
        joined_starts, joined_bodies                                                                             \
  }

// The shape that looks for others.
typedef struct Searcher {
  SearchInfo info;
  u32 slot;
  Vec3 center, velocity;
  real bounding_radius, extent, h;  // bounds have margins around them
  real margin;                      // of planes and of shapes in trees
#if FEATURE_MANIFOLDS
  Vec3 box;
  real rotational_speed, round;
#endif
} Searcher;

// Whether a pair may make contacts, for all that its shapes and bodies say: not two bodies that a joint holds together
// and keeps from colliding.
static inline bool is_pair(const PairSearch* s, ShapeInfo a, ShapeInfo b, BodyInfo body_a, BodyInfo body_b) {
#if FEATURE_JOINTS
  for (u32 k = s->joined_starts[a.body]; k < s->joined_starts[a.body + 1u]; ++k) {
    if (s->joined_bodies[k] == b.body) return false;
  }
#endif
  return may_touch(a, b, body_a, body_b);
}

// Surfaces are many shapes that cannot move: where there are any, only what can move looks for others in the first
// search, and for what cannot on all sides. The same where many sleep: only what is awake looks for others.
#define SEARCHES_AROUND (FEATURE_FACETS || FEATURE_SLEEPING)
static inline bool is_sought(const SearchInfo* info) {
  if (FEATURE_SLEEPING) return info->looks == 0u;
  return FEATURE_FACETS && info->body.kind != BODY_DYNAMIC;
}

// Two shapes of which neither looks for others are no pair.
static inline bool one_looks(u32 looks_a, u32 looks_b) { return !FEATURE_SLEEPING || (looks_a | looks_b) != 0u; }

// Where a search puts what it finds. In the first one each pair is found once, from either side, and given to its
// owner: counts[owner] and the first FOUND of found[owner]. In the second one a shape fills the list of its own
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

static inline Vec3 bound_center(global const Bound* bound) {
  return make3(bound->center[0], bound->center[1], bound->center[2]);
}

static inline Vec3 search_position(global const Vec4* positions, u32 body) {
  return make3(positions[body].x, positions[body].y, positions[body].z);
}

static inline Vec3 center_velocity(global const Bound* bound, global const Vec4* positions,
                                   global const Motion* motions, u32 body) {
  return point_velocity(&motions[body], sub3(bound_center(bound), search_position(positions, body)));
}

static inline real rotational_speed_of(global const Bound* bound, u32 kind, global const Motion* motion) {
  if (kind == SHAPE_SPHERE) return (real)0;
  return length3(make3(motion->w[0], motion->w[1], motion->w[2])) * bound->bounding_radius;
}

// Puts shape i into a slot. One without extent gets a bounding radius that no other shape comes near.
static inline void gather_search_info(u32 slot, u32 i, global const Bound* bound, Cell cell,
                                      global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                                      global const Vec4* positions, global const Motion* motions,
                                      global const Sleeper* sleepers, global real* search_bounds,
                                      global SearchInfo* search_infos, global u32* shape_slots,
                                      const StepParams* params) {
  shape_slots[i] = slot;
  const u32 body = shape_infos[i].body, count = top_level_count(params);
  const Vec3 velocity = center_velocity(bound, positions, motions, body);
  global real* mine = search_bounds + slot;
  mine[SEARCH_ARRAY(SEARCH_X, count)] = bound->center[0];
  mine[SEARCH_ARRAY(SEARCH_Y, count)] = bound->center[1];
  mine[SEARCH_ARRAY(SEARCH_Z, count)] = bound->center[2];
  mine[SEARCH_ARRAY(SEARCH_BOUNDING_RADIUS, count)] = bound->extent > (real)0 ? bound->bounding_radius : (real)-1e37;
  mine[SEARCH_ARRAY(SEARCH_EXTENT, count)] = bound->extent;
  mine[SEARCH_ARRAY(SEARCH_VX, count)] = velocity.x;
  mine[SEARCH_ARRAY(SEARCH_VY, count)] = velocity.y;
  mine[SEARCH_ARRAY(SEARCH_VZ, count)] = velocity.z;
#if FEATURE_MANIFOLDS
  mine[SEARCH_ARRAY(SEARCH_BOX_X, count)] = bound->box[0];
  mine[SEARCH_ARRAY(SEARCH_BOX_Y, count)] = bound->box[1];
  mine[SEARCH_ARRAY(SEARCH_BOX_Z, count)] = bound->box[2];
  mine[SEARCH_ARRAY(SEARCH_ROTATIONAL_SPEED, count)] = rotational_speed_of(bound, shape_infos[i].kind, &motions[body]);
  mine[SEARCH_ARRAY(SEARCH_ROUND, count)] = shape_infos[i].kind == SHAPE_SPHERE ? (real)1 : (real)0;
#endif
  SearchInfo info;
  info.shape = shape_infos[i];
  info.body = body_infos[body];
  info.index = i;
  info.cell_y = cell.y;
  info.cell_z = cell.z;
#if FEATURE_SLEEPING
  info.looks = looks_for_others(info.shape, params->bodies, body_infos, motions, sleepers) ? 1u : 0u;
#else
  info.looks = 1u;
#endif
  search_infos[slot] = info;
}

static inline PlaneInfo make_plane_info(u32 plane, global const BodyInfo* body_infos,
                                        global const ShapeInfo* shape_infos, global const Shape* shapes,
                                        global const Vec4* positions, global const Vec4* orientations,
                                        global const Motion* motions, global const Sleeper* sleepers, u32 bodies) {
  const u32 body = shape_infos[plane].body;
  const Pose pose = make_pose(positions[body], orientations[body]);
  const Vec3 point = shape_center(pose, &shapes[plane]);
  const Vec3 normal = plane_normal(shape_rotation(pose, &shapes[plane]));
  const Vec3 v = make3(motions[body].v[0], motions[body].v[1], motions[body].v[2]);
  const Vec3 angular_velocity = make3(motions[body].w[0], motions[body].w[1], motions[body].w[2]);
  const bool still = dot3(v, v) + dot3(angular_velocity, angular_velocity) == (real)0;
  PlaneInfo info = {{point.x, point.y, point.z}, {normal.x, normal.y, normal.z}, still ? (real)1.001 : (real)1e30, 1u};
#if FEATURE_SLEEPING
  info.looks = looks_for_others(shape_infos[plane], bodies, body_infos, motions, sleepers) ? 1u : 0u;
#endif
  return info;
}

// The planes of all worlds, and no pairs yet.
static inline void gather_planes(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                                 global const ShapeInfo* shape_infos, global const Shape* shapes,
                                 global const u32* planes, global const Vec4* positions,
                                 global const Vec4* orientations, global const Motion* motions,
                                 global const Sleeper* sleepers, global PlaneInfo* plane_infos, global u32* pair_starts,
                                 const StepParams* params) {
  FOR_EACH(w, params->worlds) {
    const WorldRange world = world_ranges[w];
    for (u32 k = world.first_plane; k < world.first_plane + world.plane_count; ++k)
      plane_infos[k] = make_plane_info(planes[k], body_infos, shape_infos, shapes, positions, orientations, motions,
                                       sleepers, params->bodies);
  }
  FOR_EACH(i, params->shapes + 1u) { pair_starts[i] = 0u; }
}

static inline Searcher make_searcher(const PairSearch* s, const StepParams* params, u32 slot) {
  global const real* mine = s->search_bounds + slot;
  const u32 count = top_level_count(params);
  Searcher me;
  me.info = s->search_infos[slot];
  me.slot = slot;
  me.extent = mine[SEARCH_ARRAY(SEARCH_EXTENT, count)];
  me.margin = shape_margin(params, (real)0, (real)0);
  me.h = step_length(params);
  me.center = make3(mine[SEARCH_ARRAY(SEARCH_X, count)], mine[SEARCH_ARRAY(SEARCH_Y, count)],
                    mine[SEARCH_ARRAY(SEARCH_Z, count)]);
  me.velocity = make3(mine[SEARCH_ARRAY(SEARCH_VX, count)], mine[SEARCH_ARRAY(SEARCH_VY, count)],
                      mine[SEARCH_ARRAY(SEARCH_VZ, count)]);
  me.bounding_radius = mine[SEARCH_ARRAY(SEARCH_BOUNDING_RADIUS, count)];
#if FEATURE_MANIFOLDS
  me.box = make3(mine[SEARCH_ARRAY(SEARCH_BOX_X, count)], mine[SEARCH_ARRAY(SEARCH_BOX_Y, count)],
                 mine[SEARCH_ARRAY(SEARCH_BOX_Z, count)]);
  me.rotational_speed = mine[SEARCH_ARRAY(SEARCH_ROTATIONAL_SPEED, count)];
  me.round = mine[SEARCH_ARRAY(SEARCH_ROUND, count)];
#endif
  return me;
}

// Bit k is set where the shape at `slot` + k is in range.
static inline u32 shapes_in_range(const PairSearch* s, const Searcher* me, u32 slot, u32 count) {
  global const real* other = s->search_bounds + slot;
  const lane dx = me->center.x - LANE_LOAD(other + SEARCH_ARRAY(SEARCH_X, count));
  const lane dy = me->center.y - LANE_LOAD(other + SEARCH_ARRAY(SEARCH_Y, count));
  const lane dz = me->center.z - LANE_LOAD(other + SEARCH_ARRAY(SEARCH_Z, count));
  const lane ux = me->velocity.x - LANE_LOAD(other + SEARCH_ARRAY(SEARCH_VX, count));
  const lane uy = me->velocity.y - LANE_LOAD(other + SEARCH_ARRAY(SEARCH_VY, count));
  const lane uz = me->velocity.z - LANE_LOAD(other + SEARCH_ARRAY(SEARCH_VZ, count));
  const lane gap = sqrt(dx * dx + dy * dy + dz * dz) -
                   (me->bounding_radius + LANE_LOAD(other + SEARCH_ARRAY(SEARCH_BOUNDING_RADIUS, count)));
  const lane speed = sqrt(ux * ux + uy * uy + uz * uz);
#if FEATURE_MANIFOLDS
  const lane rotational_speed = me->rotational_speed + LANE_LOAD(other + SEARCH_ARRAY(SEARCH_ROTATIONAL_SPEED, count));
  const lane box_x = me->box.x + LANE_LOAD(other + SEARCH_ARRAY(SEARCH_BOX_X, count));
  const lane box_y = me->box.y + LANE_LOAD(other + SEARCH_ARRAY(SEARCH_BOX_Y, count));
  const lane box_z = me->box.z + LANE_LOAD(other + SEARCH_ARRAY(SEARCH_BOX_Z, count));
  const lane both_round = me->round * LANE_LOAD(other + SEARCH_ARRAY(SEARCH_ROUND, count));
  return LANE_BITS((gap <= me->h * speed) &
                   ((both_round > (lane)0) | ((fabs(dx) <= box_x + me->h * (fabs(ux) + rotational_speed)) &
                                              (fabs(dy) <= box_y + me->h * (fabs(uy) + rotational_speed)) &
                                              (fabs(dz) <= box_z + me->h * (fabs(uz) + rotational_speed)))));
#else
  return LANE_BITS(gap <= me->h * speed);
#endif
}

static inline void search_planes(const PairSearch* s, const Searcher* me, Finds* finds) {
  const WorldRange world = s->world_ranges[me->info.body.world];
  for (u32 k = world.first_plane; k < world.first_plane + world.plane_count; ++k) {
    const PlaneInfo plane = s->plane_infos[k];
    const Vec3 point = make3(plane.point[0], plane.point[1], plane.point[2]);
    const Vec3 normal = make3(plane.normal[0], plane.normal[1], plane.normal[2]);
    const real gap = dot3(normal, sub3(me->center, point)) - me->bounding_radius;
    const u32 j = s->planes[k];
    if (gap + me->bounding_radius > plane.slack * (me->extent + me->margin)) continue;
    if (!one_looks(me->info.looks, plane.looks)) continue;
    const ShapeInfo other = s->shape_infos[j];
    const u32 body_a = me->info.shape.body, body_b = other.body;
    if (!is_pair(s, me->info.shape, other, me->info.body, s->body_infos[body_b])) continue;
    const Vec3 touch = sub3(me->center, scale3(me->bounding_radius, normal));
    const real speed = approach_speed(normal, &s->motions[body_a], sub3(touch, search_position(s->positions, body_a)),
                                      &s->motions[body_b], sub3(touch, search_position(s->positions, body_b)));
    if (gap <= me->margin + me->h * speed) add_pair(finds, me->info.index, j);
  }
}

// The totals of the list, told by one work-item; true where the list is too short.
static inline bool tell_pairs(u32 total, global u32* counters, const StepParams* params) {
  const bool full = total > params->pair_capacity;
  if (get_global_id(0) == 0) {
    counters[COUNTER_PAIRS_NEEDED] = total;
    counters[COUNTER_PAIRS] = full ? 0u : total;
    if (full) counters[COUNTER_STATUS] |= STATUS_PAIRS_FULL;
  }
  return full;
}

// Sorts the partners of shape i into its part of the list. They may lie in the first half of it: from behind, each
// moves to its own slot.
static inline void write_pairs(u32 i, global u32* partners, u32 count, global Pair* pairs) {
  sort_ascending(partners, count);
  for (u32 k = count; k > 0u; --k) {
    const u32 partner = partners[k - 1u];
    pairs[k - 1u].shape_a = i;
    pairs[k - 1u].shape_b = partner;
  }
}

#endif
