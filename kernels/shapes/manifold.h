// Shapes in the world, and how two of them meet. cpu_reference/shapes/manifold.hpp is the twin and says more.
#ifndef LOCKSTEP_MANIFOLD_H
#define LOCKSTEP_MANIFOLD_H

#include "called.h"
#include "math.h"

#if FEATURE_MANIFOLDS
#define PAIR_POINTS MANIFOLD_POINTS
#else
#define PAIR_POINTS 1u  // spheres and planes meet at one
#endif

// A body's frame in the world.
typedef struct Pose {
  Vec3 position;
  Quat orientation;
} Pose;

// A shape in the world. `alone`: a facet is taken for itself, not for a part of its surface. `displacement` and
// `angular_displacement`: how far the centre moves within the step, and by what the shape rotates about it, but for
// what forces add, less than `margin`. `lag`: the share of the step that has passed when contacts are evaluated, on the
// mean of its sub-steps. `first_seam` and `seam_count`: which shapes cover edges of it.
typedef struct WorldShape {
  Vec3 center;
  Quat rotation;
  Vec3 size;
  u32 hull;
  bool alone;
  Vec3 displacement, angular_displacement;
  real margin, lag;
#if FEATURE_SEAMS
  u32 first_seam, seam_count;
#endif
} WorldShape;

// How far a point of shape a goes past one of shape b until contacts are evaluated, on the mean of the sub-steps. Of
// what rolls these are points of the axis: the line on its side that touches goes with that.
static inline Vec3 lagging_displacement(const WorldShape* a, Vec3 at_a, const WorldShape* b, Vec3 at_b) {
  const Vec3 of_a = add3(a->displacement, cross3(a->angular_displacement, sub3(at_a, a->center)));
  const Vec3 of_b = add3(b->displacement, cross3(b->angular_displacement, sub3(at_b, b->center)));
  return scale3(a->lag, sub3(of_a, of_b));
}

// How far the point where two lines cross, seen along n, moves along either while the first goes past the second.
typedef struct CrossingShift {
  real along_first, along_second;  // in parts of u and v
} CrossingShift;
static inline CrossingShift crossing_shift(Vec3 u, Vec3 v, Vec3 n, Vec3 displacement) {
  const real across = dot3(cross3(u, v), n);
  const CrossingShift shift = {-dot3(cross3(displacement, v), n) / across, -dot3(cross3(displacement, u), n) / across};
  return shift;
}

typedef struct HullTables {
  global const Hull* hulls;
  global const Vec4* vertices;
  global const Vec4* planes;
  global const HullFace* faces;
  global const HullEdge* edges;
  global const u32* corners;
  global const Facet* facets;
  global const FacetEdge* facet_edges;
#if FEATURE_SEAMS
  global const Seam* seams;
#endif
} HullTables;

static inline Vec3 facet_vertex(global const Facet* facet, u32 i) {
  return make3(facet->corners[3u * i], facet->corners[3u * i + 1u], facet->corners[3u * i + 2u]);
}

typedef struct ManifoldPoint {
  Vec3 anchor_a, anchor_b;
  u32 feature;
} ManifoldPoint;

typedef struct Manifold {
  Vec3 normal;
  u32 frame;
  real radius_a, radius_b;
  u32 count;
  ManifoldPoint points[PAIR_POINTS];
} Manifold;

static inline real gap_at(const Manifold* m, u32 k) {
  return dot3(m->normal, sub3(m->points[k].anchor_a, m->points[k].anchor_b)) - m->radius_a - m->radius_b;
}

// That of a meeting, where one of the two rolls.
static inline u32 frame_on_round(u32 frame, real radius_a, real radius_b) {
  return frame == NORMAL_FIXED && radius_b > (real)0 && !(radius_a > (real)0) ? NORMAL_FIXED_ON_B : frame;
}

static inline u32 flipped_frame(u32 frame) {
  if (frame == NORMAL_OF_A) return NORMAL_OF_B;
  if (frame == NORMAL_OF_B) return NORMAL_OF_A;
  if (frame == NORMAL_FIXED) return NORMAL_FIXED_ON_B;
  return frame == NORMAL_FIXED_ON_B ? NORMAL_FIXED : frame;
}

static inline void flip(Manifold* m) {
  m->normal = scale3((real)-1, m->normal);
  m->frame = flipped_frame(m->frame);
  const real radius = m->radius_a;
  m->radius_a = m->radius_b;
  m->radius_b = radius;
  for (u32 k = 0u; k < m->count; ++k) {
    const Vec3 anchor = m->points[k].anchor_a;
    m->points[k].anchor_a = m->points[k].anchor_b;
    m->points[k].anchor_b = anchor;
  }
}

static inline Manifold no_manifold(void) {
  Manifold m;
  m.count = 0u;
  return m;
}

static inline Manifold manifold_at(Vec3 normal, u32 frame, Vec3 anchor_a, real radius_a, Vec3 anchor_b, real radius_b,
                                   u32 feature) {
  Manifold m;
  m.normal = normal;
  m.frame = frame;
  m.radius_a = radius_a;
  m.radius_b = radius_b;
  m.count = 1u;
  m.points[0].anchor_a = anchor_a;
  m.points[0].anchor_b = anchor_b;
  m.points[0].feature = feature;
  return m;
}

static inline Pose make_pose(Vec4 position, Vec4 orientation) {
  Pose pose;
  pose.position = make3(position.x, position.y, position.z);
  pose.orientation = quat(orientation);
  return pose;
}

// The origin of the shape's frame in the world: of a shape at the centre of mass exactly the body's position.
static inline Vec3 shape_center(Pose pose, global const Shape* shape) {
  return add3(pose.position, rotate3(pose.orientation, make3(shape->offset[0], shape->offset[1], shape->offset[2])));
}

static inline Quat shape_rotation(Pose pose, global const Shape* shape) {
  return multiply4(pose.orientation,
                   make4(shape->rotation[0], shape->rotation[1], shape->rotation[2], shape->rotation[3]));
}

#endif
