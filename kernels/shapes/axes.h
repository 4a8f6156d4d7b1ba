// The axes of a turned shape, and parts of shapes that several pairs need. cpu_reference/shapes/axes.hpp is the twin
// and says more.
#ifndef LOCKSTEP_AXES_H
#define LOCKSTEP_AXES_H

#include "shapes/manifold.h"

// The axes of a frame in another one: the columns of its rotation matrix.
typedef struct Axes {
  Vec3 x, y, z;
} Axes;

// Of a unit quaternion (survey 2.1.2).
static inline Axes axes_of(Quat q) {
  const real x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const real xx = q.x * x2, yy = q.y * y2, zz = q.z * z2;
  const real xy = q.x * y2, xz = q.x * z2, yz = q.y * z2;
  const real wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  Axes axes;
  axes.x = make3((real)1 - (yy + zz), xy + wz, xz - wy);
  axes.y = make3(xy - wz, (real)1 - (xx + zz), yz + wx);
  axes.z = make3(xz + wy, yz - wx, (real)1 - (xx + yy));
  return axes;
}

static inline Vec3 into_frame(Axes axes, Vec3 v) { return make3(dot3(axes.x, v), dot3(axes.y, v), dot3(axes.z, v)); }

static inline Vec3 out_of_frame(Axes axes, Vec3 v) {
  return add3(add3(scale3(v.x, axes.x), scale3(v.y, axes.y)), scale3(v.z, axes.z));
}

static inline real clamp_to(real x, real limit) { return x < -limit ? -limit : x > limit ? limit : x; }

// From core point b to core point a, or `fallback` where they coincide but for the rounding of shapes of
// this size.
static inline Vec3 direction_between(Vec3 a, Vec3 b, real size, Vec3 fallback) {
  const Vec3 d = sub3(a, b);
  const real distance = length3(d);
  return distance > (real)1e-6 * size ? make3(d.x / distance, d.y / distance, d.z / distance) : fallback;
}

// The i-th sixteenth of the way around, from x by way of y.
static inline Vec3 around_sixteenth(Vec3 x, Vec3 y, u32 i) {
  const real cosines[5] = {(real)1, (real)0.92387953251128674, (real)0.70710678118654752, (real)0.38268343236508977,
                           (real)0};
  const u32 k = i & 7;
  const real c = k < 5 ? cosines[k] : -cosines[8 - k], s = k < 5 ? cosines[4 - k] : cosines[k - 4];
  const real side = (i & 8) == 0 ? (real)1 : (real)-1;
  return add3(scale3(side * c, x), scale3(side * s, y));
}

// Adds a point to a manifold whose normal is set.
static inline Manifold with_point(Manifold m, Vec3 anchor_a, Vec3 anchor_b, u32 feature) {
  m.points[m.count].anchor_a = anchor_a;
  m.points[m.count].anchor_b = anchor_b;
  m.points[m.count].feature = feature;
  m.count = m.count + 1;
  return m;
}

// A manifold without points yet.
static inline Manifold manifold_along(Vec3 normal, u32 frame, real radius_a, real radius_b) {
  Manifold m = no_manifold();
  m.normal = normal;
  m.frame = frame;
  m.radius_a = radius_a;
  m.radius_b = radius_b;
  return m;
}

#endif
