// Sphere against plane: the gap is n.(a - p) - r_a (Ericson, Real-Time Collision Detection, 5.1.1).
// kernels/shapes/sphere_plane.h is the twin.
#pragma once

#include "cpu_reference/shapes/touch.hpp"

namespace lockstep::reference {

/// The point lies on the sphere's own surface, so that the arm of a rolling sphere has exactly its radius.
template <class real>
Touch<real> sphere_plane(const Placed<real>& a, const Placed<real>& b) {
  Touch<real> touch;
  touch.normal = rotate3(b.rotation, Vec3<real>{0, 0, 1});
  touch.gap = dot3(touch.normal, sub3(a.center, b.center)) - a.size.x;
  touch.point = sub3(a.center, scale3(a.size.x, touch.normal));
  return touch;
}

}  // namespace lockstep::reference
