// When within the step two shapes meet: conservative advancement. cpu_reference/shapes/advance.hpp is the twin and says
// more.
#ifndef LOCKSTEP_ADVANCE_H
#define LOCKSTEP_ADVANCE_H

#include "rigid_body.h"
#include "shapes/manifold.h"

#define ADVANCE_ROUNDS 32u

// How the body of a shape moves, and how far out the shape is carried along by its rotation.
typedef struct Mover {
  Pose pose;
  Vec3 v, w;
  real radius;
  bool unbounded;
} Mover;

static inline Mover make_mover(u32 kind, global const Shape* shape, global const Motion* motion, Pose pose) {
  const real arm = length3(make3(shape->offset[0], shape->offset[1], shape->offset[2]));
  Mover m;
  m.pose = pose;
  m.v = make3(motion->v[0], motion->v[1], motion->v[2]);
  m.w = make3(motion->w[0], motion->w[1], motion->w[2]);
  m.radius = kind == SHAPE_SPHERE ? arm : arm + shape->bounding_radius;
  m.unbounded = kind == SHAPE_PLANE;
  return m;
}

static inline Pose advance_pose(const Mover* m, real time) {
  Pose pose;
  pose.position = add3(m->pose.position, scale3(time, m->v));
  pose.orientation = integrate_orientation(m->pose.orientation, m->w, time);
  return pose;
}

// No gap along the normal from b to a closes faster in the step.
static inline real closing_speed(const Mover* a, const Mover* b, Vec3 normal, real h) {
  const Vec3 v = sub3(b->v, a->v);
  const real angular_speed_a = length3(a->w), angular_speed_b = length3(b->w);
  if ((a->unbounded && angular_speed_a > (real)0) || (b->unbounded && angular_speed_b > (real)0)) {
    const real speed = length3(v);
    const real far = length3(sub3(a->pose.position, b->pose.position)) + h * speed;
    return speed + angular_speed_a * (a->unbounded ? far + b->radius : a->radius) +
           angular_speed_b * (b->unbounded ? far + a->radius : b->radius);
  }
  return dot3(normal, v) + angular_speed_a * a->radius + angular_speed_b * b->radius;
}

// The smallest gap of a manifold that has points.
static inline real closest_gap(const Manifold* m) {
  real gap = gap_at(m, 0u);
  for (u32 k = 1u; k < m->count; ++k) {
    const real other = gap_at(m, k);
    gap = other < gap ? other : gap;
  }
  return gap;
}

static inline real advance_time(real time, real gap, real speed, real h) {
  if (!(speed > (real)0)) return h;
  const real next = time + gap / speed;
  return next < h ? next : h;
}

#if FEATURE_MANIFOLDS
// The largest sphere about the origin of a shape that is known to be inside of it; below 0 where there is none.
static inline real core_radius(u32 kind, Vec3 size, u32 hull, const HullTables* tables) {
  if (kind == SHAPE_CAPSULE) return size.x;
  if (kind == SHAPE_CYLINDER) return size.x < size.y ? size.x : size.y;
  if (kind == SHAPE_BOX) {
    const real least = size.x < size.y ? size.x : size.y;
    return least < size.z ? least : size.z;
  }
  if (kind != SHAPE_HULL || (hull & HULL_IS_FACET) != 0u) return (real)-1;
  real radius = size.x;
  for (u32 f = 0u; f < tables->hulls[hull].face_count; ++f) {
    const real distance = tables->planes[tables->hulls[hull].first_face + f].w;
    radius = distance < radius ? distance : radius;
  }
  return radius;
}

// The point of the smallest gap, the first of equals.
static inline u32 nearest_point(const Manifold* m) {
  u32 nearest = 0u;
  for (u32 k = 1u; k < m->count; ++k) {
    if (gap_at(m, k) < gap_at(m, nearest)) nearest = k;
  }
  return nearest;
}

// From the middle of side a (`of_a`) or b to the tangent plane of the other side.
static inline real middle_gap(const Manifold* m, bool of_a, Vec3 center_b) {
  const ManifoldPoint point = m->points[nearest_point(m)];
  if (of_a) return dot3(m->normal, scale3((real)-1, add3(point.anchor_b, center_b))) - m->radius_b;
  return dot3(m->normal, sub3(point.anchor_a, center_b)) - m->radius_a;
}

// Keeps the core of side a (`of_a`) or b out of the other's tangent plane.
static inline void add_core(Manifold* m, bool of_a, real radius) {
  u32 farthest = 0u;
  for (u32 k = 1u; k < m->count; ++k) {
    if (gap_at(m, k) > gap_at(m, farthest)) farthest = k;
  }
  ManifoldPoint point = m->points[nearest_point(m)];
  if (of_a) {
    point.anchor_a = make3((real)0, (real)0, (real)0);
    point.anchor_b = add3(point.anchor_b, scale3(radius - m->radius_a, m->normal));
  } else {
    point.anchor_b = make3((real)0, (real)0, (real)0);
    point.anchor_a = sub3(point.anchor_a, scale3(radius - m->radius_b, m->normal));
  }
  point.feature = CORE_FEATURE;
  if (m->count == PAIR_POINTS) {
    for (u32 k = farthest; k + 1u < m->count; ++k) m->points[k] = m->points[k + 1u];
    --m->count;
  }
  m->points[m->count++] = point;
}
#endif

// A manifold at the impact, seen from the start of the step.
static inline void bring_back(Manifold* m, const Mover* a, const Mover* b, real time) {
  const Quat later_a = integrate_orientation(a->pose.orientation, a->w, time),
             later_b = integrate_orientation(b->pose.orientation, b->w, time);
  for (u32 k = 0u; k < m->count; ++k) {
    m->points[k].anchor_a = carry3(later_a, a->pose.orientation, m->points[k].anchor_a);
    m->points[k].anchor_b = carry3(later_b, b->pose.orientation, m->points[k].anchor_b);
  }
  m->frame = NORMAL_OF_IMPACT;
}

#endif
