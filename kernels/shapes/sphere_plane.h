// Sphere against plane. cpu_reference/shapes/sphere_plane.hpp is the twin.
#ifndef LOCKSTEP_SPHERE_PLANE_H
#define LOCKSTEP_SPHERE_PLANE_H

#include "shapes/touch.h"

// The point lies on the sphere's own surface, so that the arm of a rolling sphere has exactly its radius.
static inline Touch sphere_plane(Placed a, Placed b) {
  Touch touch;
  touch.normal = rotate3(b.rotation, make3((real)0, (real)0, (real)1));
  touch.gap = dot3(touch.normal, sub3(a.center, b.center)) - a.size.x;
  touch.point = sub3(a.center, scale3(a.size.x, touch.normal));
  return touch;
}

#endif
