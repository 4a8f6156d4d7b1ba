// Sphere against plane. kernels/shapes/sphere_plane.h is the twin.
#pragma once

#include "cpu_reference/shapes/manifold.hpp"

namespace lockstep::reference {

template <class real>
Vec3<real> plane_normal(Quat<real> rotation) {
  return rotate3(rotation, Vec3<real>{0, 0, 1});
}

template <class real>
Manifold<real> sphere_plane(const WorldShape<real>& a, const WorldShape<real>& b) {
  return manifold_at(plane_normal(b.rotation), NORMAL_OF_B, a.center, a.size.x, b.center, real(0), 0);
}

}  // namespace lockstep::reference
