#pragma OPENCL FP_CONTRACT OFF
// Narrow phase (cpu_reference/collide.hpp).
#include "collide_tile.h"
#include "common.h"
#include "found_contacts.h"
#include "shapes/advance.h"
#include "shapes/may_touch.h"
#include "shapes/pairs.h"
#include "tolerances.h"
#include "types.h"

// One side of a pair.
typedef struct Side {
  u32 body, kind, hull, flags;
  u32 first_seam, seam_count;
  global const Shape* shape;
  global const Motion* motion;
  Pose pose;
  Vec3 offset, arm;  // from the centre of mass to the centre of the shape: body frame, world axes
} Side;

static inline Side collide_side(u32 i, global const ShapeInfo* shape_infos, const SideTables* tables) {
  const ShapeInfo info = shape_infos[i];
  Side side;
  side.body = info.body;
  side.kind = info.kind;
  side.hull = info.hull;
  side.flags = info.flags;
  const bool has_seams = FEATURE_SEAMS && (info.flags & SHAPE_HAS_SEAMS) != 0u;
  side.first_seam = has_seams ? tables->seam_starts[i] : 0u;
  side.seam_count = has_seams ? tables->seam_starts[i + 1u] - side.first_seam : 0u;
  side.shape = tables->shapes + i;
  side.motion = tables->motions + info.body;
  side.pose = make_pose(tables->positions[info.body], tables->orientations[info.body]);
  side.offset = make3(side.shape->offset[0], side.shape->offset[1], side.shape->offset[2]);
  side.arm = rotate3(side.pose.orientation, side.offset);
  return side;
}

// The share of a step that has passed when contacts are evaluated, at the start of each sub-step, on their mean.
static inline real contact_lag(const StepParams* params) {
  return (real)0.5 * (real)(params->substeps - 1u) / (real)params->substeps;
}

// `h`: what is left of the step.
static inline WorldShape collide_world_shape(const Side* side, Vec3 center, bool alone, real margin, real lag, real h) {
  WorldShape world_shape;
  world_shape.center = center;
  world_shape.rotation = shape_rotation(side->pose, side->shape);
  world_shape.size = make3(side->shape->size[0], side->shape->size[1], side->shape->size[2]);
  world_shape.hull = side->hull;
  world_shape.alone = alone;
  world_shape.margin = margin;
  world_shape.lag = lag;
#if FEATURE_SEAMS
  world_shape.first_seam = side->first_seam;
  world_shape.seam_count = alone ? 0u : side->seam_count;
#endif
  world_shape.displacement = scale3(h, point_velocity(side->motion, side->arm));
  world_shape.angular_displacement = scale3(h, make3(side->motion->w[0], side->motion->w[1], side->motion->w[2]));
  return world_shape;
}

static inline real collide_slop(const StepParams* params, const Side* a, const Side* b) {
  return pair_slop(params, pair_radius(a->shape->size[3], b->shape->size[3]),
                   pair_radius(solid_radius(a->shape), solid_radius(b->shape)));
}

static inline real collide_displacement(const StepParams* params, const Side* side) {
  return shape_displacement(step_length(params), point_velocity(side->motion, side->arm), side->motion,
                            side->shape->bounding_radius);
}

static inline real collide_largest_margin(const StepParams* params, const Side* a, const Side* b) {
  return pair_margin(params, own_margin(params, a->shape->bounding_radius, a->shape->size[3]),
                     own_margin(params, b->shape->bounding_radius, b->shape->size[3]));
}
static inline real collide_margin(const StepParams* params, const Side* a, const Side* b) {
  const real own = pair_radius(own_margin(params, a->shape->bounding_radius, a->shape->size[3]),
                               own_margin(params, b->shape->bounding_radius, b->shape->size[3]));
  return params->margin + used_margin(own, collide_displacement(params, a) + collide_displacement(params, b));
}

// The largest gap that can matter.
static inline real collide_limit(const StepParams* params, const Side* a, const Side* b, Vec3 arm_b) {
  const Vec3 v = sub3(point_velocity(b->motion, arm_b), point_velocity(a->motion, a->arm));
  const Vec3 w = sub3(make3(b->motion->w[0], b->motion->w[1], b->motion->w[2]),
                      make3(a->motion->w[0], a->motion->w[1], a->motion->w[2]));
  return collide_margin(params, a, b) + step_length(params) * (length3(v) + length3(w) * a->shape->bounding_radius);
}

// From the centre of mass of b to that of a.
static inline Vec3 collide_offset_ab(const Side* a, const Side* b) { return sub3(a->pose.position, b->pose.position); }

// The centre of shape b, seen from that of shape a.
static inline Vec3 collide_center_b(const Side* a, const Side* b) {
  return sub3(b->arm, add3(a->arm, collide_offset_ab(a, b)));
}

// `alone`: facets, and shapes with seams, are taken for themselves.
static inline Manifold collide_sides(const StepParams* params, const Side* a, const Side* b, const HullTables* tables,
                                     real limit, bool alone, real h) {
  const real margin = collide_largest_margin(params, a, b), lag = contact_lag(params);
  const WorldShape shape_a = collide_world_shape(a, make3((real)0, (real)0, (real)0), alone, margin, lag, h);
  const WorldShape shape_b = collide_world_shape(b, collide_center_b(a, b), alone, margin, lag, h);
  return collide_shapes(a->kind, &shape_a, b->kind, &shape_b, tables, limit);
}

static inline bool collide_in_range(const StepParams* params, const Manifold* m, u32 k, const Side* a, const Side* b,
                                    Vec3 offset_ab, real time_left) {
  const Vec3 arm = add3(a->arm, sub3(m->points[k].anchor_a, scale3(m->radius_a, m->normal)));
  const real speed = approach_speed(m->normal, a->motion, arm, b->motion, add3(arm, offset_ab));
  return gap_at(m, k) <= collide_margin(params, a, b) + time_left * speed;
}

// Puts one more point into a list that is ordered by feature.
static inline void collide_insert(Manifold* m, ManifoldPoint point) {
  u32 slot = m->count++;
  for (; slot > 0u && m->points[slot - 1u].feature > point.feature; --slot) m->points[slot] = m->points[slot - 1u];
  m->points[slot] = point;
}

// The points that are in range with so much time of the step left; each anchor is seen from the centre of its shape.
static inline void collide_keep(const StepParams* params, Manifold* m, const Side* a, const Side* b, real time_left) {
  const Vec3 offset_ab = collide_offset_ab(a, b), center_b = collide_center_b(a, b);
  const u32 found = m->count;
  m->count = 0u;
  for (u32 k = 0u; k < found; ++k) {
    if (collide_in_range(params, m, k, a, b, offset_ab, time_left)) collide_insert(m, m->points[k]);
  }
  for (u32 k = 0u; k < m->count; ++k) m->points[k].anchor_b = sub3(m->points[k].anchor_b, center_b);
}

#if FEATURE_CONTINUOUS
static inline Side collide_moved(const Side* side, const Mover* mover, real time) {
  Side moved = *side;
  moved.pose = advance_pose(mover, time);
  moved.arm = rotate3(moved.pose.orientation, side->offset);
  return moved;
}

#if FEATURE_MANIFOLDS
// Adds the core of the continuous side where its middle would come to the tangent plane of the other side in the time
// that is left.
static inline void collide_add_core(const Side* a, const Side* b, const HullTables* tables, real time_left,
                                    Manifold* m) {
  const bool of_a = (a->flags & SHAPE_IS_CONTINUOUS) != 0u;
  const Side* side = of_a ? a : b;
  const Vec3 size = make3(side->shape->size[0], side->shape->size[1], side->shape->size[2]);
  const real radius = core_radius(side->kind, size, side->hull, tables);
  if (m->count == 0u || radius < (real)0) return;
  const Vec3 offset_ab = collide_offset_ab(a, b), center_b = collide_center_b(a, b);
  const Vec3 arm_a = of_a ? a->arm : sub3(b->arm, offset_ab);
  const real speed = approach_speed(m->normal, a->motion, arm_a, b->motion, add3(arm_a, offset_ab));
  if (middle_gap(m, of_a, center_b) < time_left * speed) add_core(m, of_a, radius);
}
#endif

static inline bool collide_is_facet(const Side* side) {
  const WorldShape shape =
      collide_world_shape(side, make3((real)0, (real)0, (real)0), false, (real)0, (real)0, (real)0);
  return is_facet(side->kind, &shape);
}

// The points at the impact, or at the end of the step where the two do not meet before. On its way to a facet a body
// may be beside it: until it is there the facet is taken for itself. And so is a shape with seams.
static inline void collide_at_impact(const StepParams* params, const Side* a, const Side* b, const HullTables* tables,
                                     real limit, Manifold* m) {
  const real h = step_length(params), slop = collide_slop(params, a, b);
  *m = collide_sides(params, a, b, tables, limit, true, h);
  const Mover mover_a = make_mover(a->kind, a->shape, a->motion, a->pose);
  const Mover mover_b = make_mover(b->kind, b->shape, b->motion, b->pose);
  Side moved_a = *a, moved_b = *b;
  real time = (real)0;
  for (u32 round = 0u; round < ADVANCE_ROUNDS && m->count > 0u && time < h && closest_gap(m) > slop; ++round) {
    time = advance_time(time, closest_gap(m), closing_speed(&mover_a, &mover_b, m->normal, h), h);
    moved_a = collide_moved(a, &mover_a, time);
    moved_b = collide_moved(b, &mover_b, time);
    *m = collide_sides(params, &moved_a, &moved_b, tables, limit, true, h);
  }
  if (collide_is_facet(a) || collide_is_facet(b) || a->seam_count + b->seam_count > 0u)
    *m = collide_sides(params, &moved_a, &moved_b, tables, limit, false, h - time);
  collide_keep(params, m, &moved_a, &moved_b, h - time);
#if FEATURE_MANIFOLDS
  collide_add_core(&moved_a, &moved_b, tables, h - time, m);
#endif
  if (time > (real)0) bring_back(m, &mover_a, &mover_b, time);
}
#endif

static inline Manifold collide_pair(const StepParams* params, const Side* a, const Side* b, const HullTables* tables) {
  if (IS_TRIGGER(*a) || IS_TRIGGER(*b)) return no_manifold();
  const real limit = collide_limit(params, a, b, add3(a->arm, collide_offset_ab(a, b)));
  Manifold m;
#if FEATURE_CONTINUOUS
  if (((a->flags | b->flags) & SHAPE_IS_CONTINUOUS) != 0u) {
    collide_at_impact(params, a, b, tables, limit, &m);
    return m;
  }
#endif
  const real h = step_length(params);
  m = collide_sides(params, a, b, tables, limit, false, h);
  collide_keep(params, &m, a, b, h);
  return m;
}

// Everything else about a pair is done for it alone.
static inline void collide_alone(const StepParams* params, u32 p, Pair pair, const HullTables* tables,
                                 const SideTables* sides, global const BodyInfo* body_infos,
                                 global const ShapeInfo* shape_infos, global FoundContacts* found_contacts,
                                 global u32* contact_starts) {
  const Side a = collide_side(pair.shape_a, shape_infos, sides);
  const Side b = collide_side(pair.shape_b, shape_infos, sides);
  const Manifold m = collide_pair(params, &a, &b, tables);
  contact_starts[p] = m.count;
  if (m.count == 0u) return;
  global FoundContacts* found = found_contacts + p;
  found->contact = found_contact(pair, a.body, b.body, body_infos[a.body].world, m.frame);
  found_store(found, &m, a.pose.orientation, a.offset, b.pose.orientation, b.offset);
}

// What each pair has, and at how many points.
kernel void collide_pairs(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                          global const Shape* shapes, global const Hull* hulls, global const Vec4* hull_vertices,
                          global const Vec4* hull_planes, global const HullFace* hull_faces,
                          global const HullEdge* hull_edges, global const u32* hull_corners, global const Facet* facets,
                          global const FacetEdge* facet_edges, global const u32* seam_starts, global const Seam* seams,
                          global const Seam* current_seams, global const Vec4* positions,
                          global const Vec4* orientations, global const Motion* motions, global const Pair* pairs,
                          global u32* contact_starts, global FoundContacts* found_contacts, global const u32* counters,
                          const u32 tile_pairs, const StepParams params) {
  const HullTables tables = {
    hulls,
    hull_vertices,
    hull_planes,
    hull_faces,
    hull_edges,
    hull_corners,
    facets,
    facet_edges,
#if FEATURE_MOVING_SEAMS
    current_seams,
#elif FEATURE_SEAMS
    seams,
#endif
  };
  const SideTables sides = {shapes, positions, orientations, motions, seam_starts};
  const u32 count = counters[COUNTER_PAIRS];
  if (get_global_id(0) == 0) contact_starts[count] = 0u;
  FOR_EACH(t, (count + tile_pairs - 1u) / tile_pairs) {
    const u32 first = t * tile_pairs, end = min(first + tile_pairs, count);
#if LANES > 1 && FEATURE_BOXES
    Tile tile;
    tile_sort(&tile, first, end, pairs, shape_infos);
    tile_collide(&params, &tile, &sides, body_infos, found_contacts, contact_starts);
    const TileList* others = &tile.lists[TILE_OTHERS];
    for (u32 i = 0u; i < others->count; ++i) {
      const u32 p = first + others->at[i];
#else
    for (u32 p = first; p < end; ++p) {
#endif
      collide_alone(&params, p, pairs[p], &tables, &sides, body_infos, shape_infos, found_contacts, contact_starts);
    }
  }
}

// After the scan of contact_starts. The contacts of a world follow each other, as its shapes do.
kernel void collide_write(global const WorldRange* world_ranges, global const u32* pair_starts,
                          global const u32* contact_starts, global const FoundContacts* found_contacts,
                          global Contact* contacts, global ContactPoint* contact_points, global u32* counters,
                          const StepParams params) {
  const u32 count = counters[COUNTER_PAIRS];
  const u32 total = contact_starts[count];
  const bool full = total > params.contact_capacity;
  if (get_global_id(0) == 0) {
    counters[COUNTER_CONTACTS_NEEDED] = total;
    counters[COUNTER_CONTACTS] = full ? 0u : total;
    if (full) counters[COUNTER_STATUS] |= STATUS_CONTACTS_FULL;
  }
  FOR_EACH(p, full ? 0u : count) {
    const u32 start = contact_starts[p], end = contact_starts[p + 1u];
    if (start == end) continue;
    global const FoundContacts* found = found_contacts + p;
    Contact contact = found->contact;
    const u32 first = contact_starts[pair_starts[world_ranges[contact.world].first_shape]];
    const Real4 normal = vload4(0, found->normal);
    for (u32 i = start; i < end; ++i) {
      contact.feature = found->features[i - start];
      contact.rank = i - first;
      contacts[i] = contact;
      vstore8(vload8(0, found->points[i - start]), 0, contact_points[i].anchor_a);
      vstore4(normal, 0, contact_points[i].normal);
    }
  }
}
