// Sphere against sphere: the gap is |a - b| - r_a - r_b along the line of centres (Ericson, Real-Time Collision
// Detection, 4.3.1). kernels/shapes/sphere_sphere.h is the twin.
#pragma once

#include "cpu_reference/shapes/touch.hpp"

namespace lockstep::reference {

/// The point lies midway between the two surfaces. Coincident centres have no direction: they part along z.
template <class real>
Touch<real> sphere_sphere(const Placed<real>& a, const Placed<real>& b) {
  const Vec3<real> d = sub3(a.center, b.center);
  const real distance = length3(d);
  Touch<real> touch;
  touch.normal = {0, 0, 1};
  if (distance > 0) touch.normal = {d.x / distance, d.y / distance, d.z / distance};
  touch.gap = distance - a.size.x - b.size.x;
  touch.point = add3(b.center, scale3(b.size.x + real(0.5) * touch.gap, touch.normal));
  return touch;
}

}  // namespace lockstep::reference
