// Sphere against plane. cpu_reference/shapes/sphere_plane.hpp is the twin.
#ifndef LOCKSTEP_SPHERE_PLANE_H
#define LOCKSTEP_SPHERE_PLANE_H

#include "shapes/touch.h"

static inline Vec3 plane_normal(Quat rotation) { return rotate3(rotation, make3((real)0, (real)0, (real)1)); }

// A sphere and the plane through `point`. They touch at the sphere's own surface, so that the arm of a rolling sphere
// has exactly its radius.
static inline Touch touch_plane(Vec3 center, real radius, Vec3 point, Vec3 normal) {
  Touch touch;
  touch.normal = normal;
  touch.gap = dot3(normal, sub3(center, point)) - radius;
  touch.point = sub3(center, scale3(radius, normal));
  return touch;
}

static inline Touch sphere_plane(Placed a, Placed b) {
  return touch_plane(a.center, a.size.x, b.center, plane_normal(b.rotation));
}

#endif
