// Sphere against plane. cpu_reference/shapes/sphere_plane.hpp is the twin.
#ifndef LOCKSTEP_SPHERE_PLANE_H
#define LOCKSTEP_SPHERE_PLANE_H

#include "shapes/manifold.h"

static inline Vec3 plane_normal(Quat rotation) { return rotate3(rotation, make3((real)0, (real)0, (real)1)); }

static inline Manifold sphere_plane(const WorldShape* a, const WorldShape* b) {
  return manifold_at(plane_normal(b->rotation), NORMAL_OF_B, a->center, a->size.x, b->center, (real)0, 0u);
}

#endif
