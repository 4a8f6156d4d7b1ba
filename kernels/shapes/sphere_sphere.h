// Sphere against sphere. cpu_reference/shapes/sphere_sphere.hpp is the twin.
#ifndef LOCKSTEP_SPHERE_SPHERE_H
#define LOCKSTEP_SPHERE_SPHERE_H

#include "shapes/touch.h"

// The point lies midway between the two surfaces. Coincident centres have no direction: they part along z.
static inline Touch sphere_sphere(Placed a, Placed b) {
  const Vec3 d = sub3(a.center, b.center);
  const real distance = length3(d);
  Touch touch;
  touch.normal = make3((real)0, (real)0, (real)1);
  if (distance > (real)0) touch.normal = make3(d.x / distance, d.y / distance, d.z / distance);
  touch.gap = distance - a.size.x - b.size.x;
  touch.point = add3(b.center, scale3(b.size.x + (real)0.5 * touch.gap, touch.normal));
  return touch;
}

#endif
