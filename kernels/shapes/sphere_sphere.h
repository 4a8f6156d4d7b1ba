// Sphere against sphere. cpu_reference/shapes/sphere_sphere.hpp is the twin.
#ifndef LOCKSTEP_SPHERE_SPHERE_H
#define LOCKSTEP_SPHERE_SPHERE_H

#include "shapes/manifold.h"

// Coincident centres have no direction: they part along z.
static inline Manifold sphere_sphere(const WorldShape* a, const WorldShape* b) {
  const Vec3 d = sub3(a->center, b->center);
  const real distance = length3(d);
  Vec3 normal = make3((real)0, (real)0, (real)1);
  if (distance > (real)0) normal = make3(d.x / distance, d.y / distance, d.z / distance);
  return manifold_at(normal, NORMAL_BETWEEN, a->center, a->size.x, b->center, b->size.x, 0u);
}

#endif
