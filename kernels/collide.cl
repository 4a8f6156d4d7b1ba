#pragma OPENCL FP_CONTRACT OFF
// Narrow phase (cpu_reference/collide.hpp).
#include "common.h"
#include "shapes/advance.h"
#include "shapes/pairs.h"
#include "shapes/reach.h"
#include "types.h"

// One side of a pair.
typedef struct Side {
  u32 kind, hull, flags;
  global const Shape* shape;
  global const Motion* motion;
  Pose pose;
  Vec3 arm;  // from the centre of mass to the centre of the shape, world axes
} Side;

static inline Side collide_side(u32 i, global const ShapeInfo* shape_infos, global const Shape* shapes,
                                global const Vec4* positions, global const Vec4* orientations,
                                global const Motion* motions) {
  const ShapeInfo info = shape_infos[i];
  Side side;
  side.kind = info.kind;
  side.hull = info.hull;
  side.flags = info.flags;
  side.shape = shapes + i;
  side.motion = motions + info.body;
  side.pose = make_pose(positions[info.body], orientations[info.body]);
  side.arm = rotate3(side.pose.orientation, make3(side.shape->offset[0], side.shape->offset[1], side.shape->offset[2]));
  return side;
}

static inline Placed collide_place(const Side* side, Vec3 center) {
  Placed placed;
  placed.center = center;
  placed.rotation = shape_rotation(side->pose, side->shape);
  placed.size = make3(side->shape->size[0], side->shape->size[1], side->shape->size[2]);
  placed.hull = side->hull;
  return placed;
}

// The largest gap that can matter.
static inline real collide_limit(StepParams params, const Side* a, const Side* b, Vec3 arm_b) {
  const Vec3 v = sub3(point_velocity(b->motion, arm_b), point_velocity(a->motion, a->arm));
  const Vec3 w = sub3(make3(b->motion->w[0], b->motion->w[1], b->motion->w[2]),
                      make3(a->motion->w[0], a->motion->w[1], a->motion->w[2]));
  return params.margin + step_length(params) * (length3(v) + length3(w) * a->shape->reach);
}

// From the centre of mass of b to that of a.
static inline Vec3 collide_apart(const Side* a, const Side* b) { return sub3(a->pose.position, b->pose.position); }

// The centre of shape b, seen from that of shape a.
static inline Vec3 collide_center_b(const Side* a, const Side* b) {
  return sub3(b->arm, add3(a->arm, collide_apart(a, b)));
}

static inline Manifold collide_sides(const Side* a, const Side* b, HullTables tables, real limit) {
  return collide_shapes(a->kind, collide_place(a, make3((real)0, (real)0, (real)0)), b->kind,
                        collide_place(b, collide_center_b(a, b)), tables, limit);
}

static inline bool collide_in_reach(StepParams params, const Manifold* m, u32 k, const Side* a, const Side* b,
                                    Vec3 apart, real time_left) {
  const Vec3 arm = add3(a->arm, sub3(m->points[k].anchor_a, scale3(m->radius_a, m->normal)));
  const real speed = approach_speed(m->normal, a->motion, arm, b->motion, add3(arm, apart));
  return gap_at(m, k) <= params.margin + time_left * speed;
}

// Puts one more point into a list that is ordered by feature.
static inline void collide_insert(Manifold* m, ManifoldPoint point) {
  u32 place = m->count++;
  for (; place > 0u && m->points[place - 1u].feature > point.feature; --place) m->points[place] = m->points[place - 1u];
  m->points[place] = point;
}

// The points that are in reach with so much time of the step left; each anchor is seen from the centre of its shape.
static inline void collide_keep(StepParams params, Manifold* m, const Side* a, const Side* b, real time_left) {
  const Vec3 apart = collide_apart(a, b), center_b = collide_center_b(a, b);
  const u32 found = m->count;
  m->count = 0u;
  for (u32 k = 0u; k < found; ++k) {
    if (collide_in_reach(params, m, k, a, b, apart, time_left)) collide_insert(m, m->points[k]);
  }
  for (u32 k = 0u; k < m->count; ++k) m->points[k].anchor_b = sub3(m->points[k].anchor_b, center_b);
}

#if FEATURE_CONTINUOUS
static inline Side collide_moved(const Side* side, const Mover* mover, real time) {
  Side moved = *side;
  moved.pose = advance_pose(mover, time);
  moved.arm =
      rotate3(moved.pose.orientation, make3(side->shape->offset[0], side->shape->offset[1], side->shape->offset[2]));
  return moved;
}

#if FEATURE_MANIFOLDS
// Adds the core of the continuous side where its middle would come to the tangent plane of the other side in the time
// that is left.
static inline void collide_add_core(const Side* a, const Side* b, HullTables tables, real time_left, Manifold* m) {
  const bool of_a = (a->flags & SHAPE_IS_CONTINUOUS) != 0u;
  const Side* side = of_a ? a : b;
  const Vec3 size = make3(side->shape->size[0], side->shape->size[1], side->shape->size[2]);
  const real radius = core_radius(side->kind, size, side->hull, tables);
  if (m->count == 0u || radius < (real)0) return;
  const Vec3 apart = collide_apart(a, b), center_b = collide_center_b(a, b);
  const Vec3 arm_a = of_a ? a->arm : sub3(b->arm, apart);
  const real speed = approach_speed(m->normal, a->motion, arm_a, b->motion, add3(arm_a, apart));
  if (middle_gap(m, of_a, center_b) < time_left * speed) add_core(m, of_a, radius);
}
#endif

// The points at the impact, or at the end of the step where the two do not meet before; `m` is the manifold at the
// start of the step.
static inline void collide_at_impact(StepParams params, const Side* a, const Side* b, HullTables tables, real limit,
                                     Manifold* m) {
  const real h = step_length(params);
  const Mover mover_a = make_mover(a->kind, a->shape, a->motion, a->pose);
  const Mover mover_b = make_mover(b->kind, b->shape, b->motion, b->pose);
  Side moved_a = *a, moved_b = *b;
  real time = (real)0;
  for (u32 round = 0u; round < ADVANCE_ROUNDS && m->count > 0u && time < h && closest_gap(m) > params.slop; ++round) {
    time = advance_time(time, closest_gap(m), closing_speed(&mover_a, &mover_b, m->normal, h), h);
    moved_a = collide_moved(a, &mover_a, time);
    moved_b = collide_moved(b, &mover_b, time);
    *m = collide_sides(&moved_a, &moved_b, tables, limit);
  }
  collide_keep(params, m, &moved_a, &moved_b, h - time);
#if FEATURE_MANIFOLDS
  collide_add_core(&moved_a, &moved_b, tables, h - time, m);
#endif
  if (time > (real)0) bring_back(m, &mover_a, &mover_b, time);
}
#endif

static inline Manifold collide_pair(StepParams params, const Side* a, const Side* b, HullTables tables) {
  if (IS_SENSOR(*a) || IS_SENSOR(*b)) return no_manifold();
  const real limit = collide_limit(params, a, b, add3(a->arm, collide_apart(a, b)));
  Manifold m = collide_sides(a, b, tables, limit);
#if FEATURE_CONTINUOUS
  if (((a->flags | b->flags) & SHAPE_IS_CONTINUOUS) != 0u) {
    collide_at_impact(params, a, b, tables, limit, &m);
    return m;
  }
#endif
  collide_keep(params, &m, a, b, step_length(params));
  return m;
}

// The manifold of each pair, about the centre of its shape a, and its number of points. `boxes_apart`: pairs of boxes
// are left to collide_boxes.cl.
kernel void collide_pairs(global const ShapeInfo* shape_infos, global const Shape* shapes, global const Hull* hulls,
                          global const Vec4* hull_vertices, global const Vec4* hull_planes,
                          global const HullFace* hull_faces, global const HullEdge* hull_edges,
                          global const u32* hull_corners, global const Vec4* positions, global const Vec4* orientations,
                          global const Motion* motions, global const Pair* pairs, global u32* contact_starts,
                          global Manifold* manifolds, global u32* counters, const u32 boxes_apart,
                          const StepParams params) {
  const HullTables tables = {hulls, hull_vertices, hull_planes, hull_faces, hull_edges, hull_corners};
  const u32 count = counters[COUNTER_PAIRS];
  u32 boxes = 0u;
  FOR_EACH(p, count + 1u) {
    u32 points = 0u;
    if (p < count) {
      const u32 two_boxes = FEATURE_BOXES && is_box_pair(shape_infos, pairs[p]) ? 1u : 0u;
      if (two_boxes & boxes_apart) continue;
      boxes += two_boxes;
      const Side a = collide_side(pairs[p].shape_a, shape_infos, shapes, positions, orientations, motions);
      const Side b = collide_side(pairs[p].shape_b, shape_infos, shapes, positions, orientations, motions);
      const Manifold m = collide_pair(params, &a, &b, tables);
      points = m.count;
      if (points > 0u) manifolds[p] = m;
    }
    contact_starts[p] = points;
  }
  if (boxes > 0u) atomic_add(&counters[COUNTER_BOX_PAIRS], boxes);
}

static inline void collide_store3(Vec3 v, global real* p) {
  p[0] = v.x;
  p[1] = v.y;
  p[2] = v.z;
}

// After the scan of contact_starts. The contacts of a world follow each other, as its shapes do.
kernel void collide_write(global const WorldRange* world_ranges, global const BodyInfo* body_infos,
                          global const ShapeInfo* shape_infos, global const Shape* shapes,
                          global const Vec4* orientations, global const u32* pair_starts, global const Pair* pairs,
                          global const u32* contact_starts, global const Manifold* manifolds, global Contact* contacts,
                          global ContactPoint* contact_points, global u32* counters, const StepParams params) {
  const u32 count = counters[COUNTER_PAIRS];
  const u32 total = contact_starts[count];
  const bool full = total > params.contact_capacity;
  if (get_global_id(0) == 0) {
    counters[COUNTER_CONTACTS_NEEDED] = total;
    counters[COUNTER_CONTACTS] = full ? 0u : total;
    if (full) counters[COUNTER_STATUS] |= STATUS_CONTACTS_FULL;
  }
  FOR_EACH(p, full ? 0u : count) {
    const u32 start = contact_starts[p], points = contact_starts[p + 1u] - start;
    if (points == 0u) continue;
    global const Manifold* m = manifolds + p;
    Contact contact;
    contact.shape_a = pairs[p].shape_a;
    contact.shape_b = pairs[p].shape_b;
    contact.body_a = shape_infos[contact.shape_a].body;
    contact.body_b = shape_infos[contact.shape_b].body;
    contact.world = body_infos[contact.body_a].world;
    contact.normal = m->frame;
    const u32 first = contact_starts[pair_starts[world_ranges[contact.world].first_shape]];
    const Quat turn_a = quat(orientations[contact.body_a]), turn_b = quat(orientations[contact.body_b]);
    global const real* offset_a = shapes[contact.shape_a].offset;
    global const real* offset_b = shapes[contact.shape_b].offset;
    Vec3 normal = m->normal;
    if (contact.normal == NORMAL_OF_A) normal = unrotate3(turn_a, normal);
    if (contact.normal == NORMAL_OF_B) normal = unrotate3(turn_b, normal);
    for (u32 k = 0u; k < points; ++k) {
      contact.feature = m->points[k].feature;
      contact.rank = start + k - first;
      contacts[start + k] = contact;
      global ContactPoint* point = contact_points + start + k;
      collide_store3(add3(make3(offset_a[0], offset_a[1], offset_a[2]), unrotate3(turn_a, m->points[k].anchor_a)),
                     point->anchor_a);
      collide_store3(add3(make3(offset_b[0], offset_b[1], offset_b[2]), unrotate3(turn_b, m->points[k].anchor_b)),
                     point->anchor_b);
      point->radius_a = m->radius_a;
      point->radius_b = m->radius_b;
      collide_store3(normal, point->normal);
      point->normal[3] = (real)0;
    }
  }
}
