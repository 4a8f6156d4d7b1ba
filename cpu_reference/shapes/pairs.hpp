// The dispatch over shape pairs. kernels/shapes/pairs.h is the twin.
#pragma once

#include "cpu_reference/shapes/sphere_plane.hpp"
#include "cpu_reference/shapes/sphere_sphere.hpp"

namespace lockstep::reference {

template <class real>
Touch<real> touch_shapes(u32 kind_a, const Placed<real>& a, u32 kind_b, const Placed<real>& b) {
#define SHAPE_PAIR(first, second, function) \
  if (kind_a == first && kind_b == second) return function(a, b);
#include "kernels/shape_pairs.def"
#undef SHAPE_PAIR
  return sphere_sphere(a, b);
}

}  // namespace lockstep::reference
