// Sphere against sphere. kernels/shapes/sphere_sphere.h is the twin.
#pragma once

#include "cpu_reference/shapes/manifold.hpp"

namespace lockstep::reference {

/// Coincident centres have no direction: they part along z.
template <class real>
Manifold<real> sphere_sphere(const WorldShape<real>& a, const WorldShape<real>& b) {
  const Vec3<real> d = sub3(a.center, b.center);
  const real distance = length3(d);
  Vec3<real> normal = {0, 0, 1};
  if (distance > 0) normal = {d.x / distance, d.y / distance, d.z / distance};
  return manifold_at(normal, NORMAL_BETWEEN, a.center, a.size.x, b.center, b.size.x, 0);
}

}  // namespace lockstep::reference
