// Sphere against cylinder. cpu_reference/shapes/sphere_cylinder.hpp is the twin.
#ifndef LOCKSTEP_SPHERE_CYLINDER_H
#define LOCKSTEP_SPHERE_CYLINDER_H

#include "shapes/cylinder.h"

// The closest point of the cylinder; from inside, through the nearer of cap and side.
static inline Manifold sphere_cylinder(const WorldShape* a, const WorldShape* b) {
  const Cylinder c = cylinder_of(b);
  const Vec3 d = sub3(a->center, b->center);
  const real height = dot3(c.axes.z, d);
  const Vec3 across = cylinder_across(&c, d);
  const real rho = length3(across);
  const Vec3 radial = rho > (real)0 ? scale3((real)1 / rho, across) : c.axes.x;
  const Vec3 cap = scale3(height < (real)0 ? (real)-1 : (real)1, c.axes.z);
  const real over_cap = (height < (real)0 ? -height : height) - c.half_length, over_side = rho - c.radius;
  if (over_cap > (real)0 && over_side > (real)0) {
    const Vec3 on_rim = add3(b->center, add3(scale3(c.half_length, cap), scale3(c.radius, radial)));
    const Vec3 normal = direction_between(a->center, on_rim, a->size.x, radial);
    return manifold_at(normal, NORMAL_FIXED, a->center, a->size.x, on_rim, (real)0, 0);
  }
  if (over_cap > over_side)
    return manifold_at(cap, NORMAL_OF_B, a->center, a->size.x, sub3(a->center, scale3(over_cap, cap)), (real)0, 0);
  const Vec3 on_axis = add3(b->center, scale3(height, c.axes.z));
  return manifold_at(radial, NORMAL_FIXED, a->center, a->size.x, on_axis, c.radius, 0);
}

#endif
