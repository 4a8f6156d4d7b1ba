// Sphere against plane: the gap is n.(a - p) - r_a (Ericson, Real-Time Collision Detection, 5.1.1).
// kernels/shapes/sphere_plane.h is the twin.
#pragma once

#include "cpu_reference/shapes/touch.hpp"

namespace lockstep::reference {

template <class real>
Vec3<real> plane_normal(Quat<real> rotation) {
  return rotate3(rotation, Vec3<real>{0, 0, 1});
}

/// A sphere and the plane through `point`. They touch at the sphere's own surface, so that the arm of a rolling sphere
/// has exactly its radius.
template <class real>
Touch<real> touch_plane(Vec3<real> center, real radius, Vec3<real> point, Vec3<real> normal) {
  return {normal, dot3(normal, sub3(center, point)) - radius, sub3(center, scale3(radius, normal))};
}

template <class real>
Touch<real> sphere_plane(const Placed<real>& a, const Placed<real>& b) {
  return touch_plane(a.center, a.size.x, b.center, plane_normal(b.rotation));
}

}  // namespace lockstep::reference
