// Capsules against spheres, planes and each other: closest points of points and segments.
// cpu_reference/shapes/capsules.hpp is the twin and says more.
#ifndef LOCKSTEP_CAPSULES_H
#define LOCKSTEP_CAPSULES_H

#include "shapes/axes.h"
#include "shapes/sphere_plane.h"

// a is the sphere.
static inline Manifold sphere_capsule(const WorldShape* a, const WorldShape* b) {
  const Axes axes = axes_of(b->rotation);
  const real height = dot3(axes.z, sub3(a->center, b->center)), t = clamp_to(height, b->size.y);
  const Vec3 core = add3(b->center, scale3(t, axes.z));
  // along the axis the sphere rolls: only an end is a point that the normal turns about
  return manifold_at(direction_between(a->center, core, a->size.x + b->size.x, axes.x),
                     t == height ? NORMAL_FIXED : NORMAL_BETWEEN, a->center, a->size.x, core, b->size.x, 0);
}

// Both ends of the core segment.
static inline Manifold capsule_plane(const WorldShape* a, const WorldShape* b) {
  const Vec3 extents = scale3(a->size.y, axes_of(a->rotation).z);
  Manifold m = manifold_along(plane_normal(b->rotation), NORMAL_OF_B, a->size.x, (real)0);
  m = with_point(m, add3(a->center, extents), b->center, 0);
  return with_point(m, sub3(a->center, extents), b->center, 1);
}

// Below this squared sine of the angle between the axes two capsules lie side by side and touch at both ends of where
// they overlap.
static inline bool side_by_side(real square_sine) { return square_sine < (real)0.0025; }

// The closest points of two segments (Ericson, Real-Time Collision Detection, 5.1.9).
static inline Manifold capsule_capsule(const WorldShape* a, const WorldShape* b) {
  const Axes axes_a = axes_of(a->rotation), axes_b = axes_of(b->rotation);
  const Vec3 u = axes_a.z, v = axes_b.z, r = sub3(a->center, b->center);
  const real cosine = dot3(u, v), du = dot3(u, r), dv = dot3(v, r);
  const Vec3 normal_of_both = cross3(u, v);
  const real square_sine = dot3(normal_of_both, normal_of_both);
  real s = square_sine > (real)(1e-12) ? clamp_to((cosine * dv - du) / square_sine, a->size.y) : (real)0;
  real t = clamp_to(cosine * s + dv, b->size.y);
  s = clamp_to(cosine * t - du, a->size.y);
  t = clamp_to(cosine * s + dv, b->size.y);
  const Vec3 core_a = add3(a->center, scale3(s, u)), core_b = add3(b->center, scale3(t, v));
  // axes that cross part along their common normal, axes that lie in each other at a right angle to themselves
  const Vec3 across = square_sine > (real)(1e-12) ? scale3((real)1 / sqrt(square_sine), normal_of_both) : axes_a.x;
  const Vec3 normal = direction_between(core_a, core_b, a->size.x + b->size.x, across);

  const real end_1 = -cosine * b->size.y - du, end_2 = cosine * b->size.y - du;  // of b, along a
  const real low = end_1 < end_2 ? end_1 : end_2, high = end_1 < end_2 ? end_2 : end_1;
  const real from = low > -a->size.y ? low : -a->size.y, to = high < a->size.y ? high : a->size.y;
  const bool between_ends = fabs(s) < a->size.y && fabs(t) < b->size.y;
  if (!side_by_side(square_sine) && between_ends) {
    const CrossingShift shift = crossing_shift(u, v, normal, lagging_displacement(a, core_a, b, core_b));
    return manifold_at(normal, NORMAL_FIXED, add3(a->center, scale3(clamp_to(s + shift.along_first, a->size.y), u)),
                       a->size.x, add3(b->center, scale3(clamp_to(t + shift.along_second, b->size.y), v)), b->size.x,
                       0);
  }
  if (!side_by_side(square_sine) || !(to - from > (real)0.01 * a->size.x)) {
    const bool past_ends = fabs(s) >= a->size.y && fabs(t) >= b->size.y;
    return manifold_at(normal, past_ends ? NORMAL_BETWEEN : NORMAL_FIXED, core_a, a->size.x, core_b, b->size.x, 0);
  }
  Manifold m = manifold_along(normal, NORMAL_FIXED, a->size.x, b->size.x);
  m = with_point(m, add3(a->center, scale3(from, u)),
                 add3(b->center, scale3(clamp_to(cosine * from + dv, b->size.y), v)), 1);
  return with_point(m, add3(a->center, scale3(to, u)),
                    add3(b->center, scale3(clamp_to(cosine * to + dv, b->size.y), v)), 2);
}

#endif
