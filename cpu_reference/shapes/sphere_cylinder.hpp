// Sphere against cylinder. kernels/shapes/sphere_cylinder.h is the twin.
#pragma once

#include "cpu_reference/shapes/cylinder.hpp"

namespace lockstep::reference {

/// The closest point of the cylinder; from inside, through the nearer of cap and side.
template <class real>
Manifold<real> sphere_cylinder(const WorldShape<real>& a, const WorldShape<real>& b) {
  const Cylinder<real> c = cylinder_of(b);
  const Vec3<real> d = sub3(a.center, b.center);
  const real height = dot3(c.axes.z, d);
  const Vec3<real> across = cylinder_across(c, d);
  const real rho = length3(across);
  const Vec3<real> radial = rho > 0 ? scale3(real(1) / rho, across) : c.axes.x;
  const Vec3<real> cap = scale3(height < 0 ? real(-1) : real(1), c.axes.z);
  const real over_cap = (height < 0 ? -height : height) - c.half_length, over_side = rho - c.radius;
  if (over_cap > 0 && over_side > 0) {
    const Vec3<real> on_rim = add3(b.center, add3(scale3(c.half_length, cap), scale3(c.radius, radial)));
    const Vec3<real> normal = direction_between(a.center, on_rim, a.size.x, radial);
    return manifold_at(normal, NORMAL_FIXED, a.center, a.size.x, on_rim, real(0), 0);
  }
  if (over_cap > over_side)
    return manifold_at(cap, NORMAL_OF_B, a.center, a.size.x, sub3(a.center, scale3(over_cap, cap)), real(0), 0);
  const Vec3<real> on_axis = add3(b.center, scale3(height, c.axes.z));
  return manifold_at(radial, NORMAL_FIXED, a.center, a.size.x, on_axis, c.radius, 0);
}

}  // namespace lockstep::reference
