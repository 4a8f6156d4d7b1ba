// The dispatch over shape pairs. cpu_reference/shapes/pairs.hpp is the twin.
#ifndef LOCKSTEP_PAIRS_H
#define LOCKSTEP_PAIRS_H

#include "shapes/sphere_plane.h"
#include "shapes/sphere_sphere.h"

static inline Touch touch_shapes(u32 kind_a, Placed a, u32 kind_b, Placed b) {
#define SHAPE_PAIR(first, second, function) \
  if (kind_a == first && kind_b == second) return function(a, b);
#include "shape_pairs.def"
#undef SHAPE_PAIR
  return sphere_sphere(a, b);
}

#endif
