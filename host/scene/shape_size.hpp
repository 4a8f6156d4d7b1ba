// How far shapes reach, and how deep they are, by the numbers that stand for their size (Shape::size).
#pragma once

#include <algorithm>

#include "host/scene/exact_math.hpp"
#include "kernels/types.h"

namespace lockstep {

/// No point of the shape is farther from its origin, m; 0 of planes. The factor covers the rounding of whoever places
/// its points.
template <class real>
real shape_bounding_radius(ShapeKind kind, const real (&size)[4]) {
  const double a = double(size[0]), b = double(size[1]), c = double(size[2]);
  switch (kind) {
    case SHAPE_SPHERE: return size[0];
    case SHAPE_CAPSULE: return static_cast<real>((a + b) * 1.000001);
    case SHAPE_CYLINDER: return static_cast<real>(exact::square_root(a * a + b * b) * 1.000001);
    case SHAPE_BOX:
    case SHAPE_HULL:
    case SHAPE_FACET: return static_cast<real>(exact::length(Vector3{a, b, c}) * 1.000001);
    default: return 0;
  }
}

/// No point is deeper inside, m; of a hull by the box along its axes, which is no less deep. Planes and triangles of
/// surfaces have no inside: 0.
template <class real>
real inner_radius(ShapeKind kind, const real (&size)[4]) {
  switch (kind) {
    case SHAPE_SPHERE:
    case SHAPE_CAPSULE: return size[0];
    case SHAPE_CYLINDER: return std::min(size[0], size[1]);
    case SHAPE_BOX:
    case SHAPE_HULL: return std::min({size[0], size[1], size[2]});
    default: return 0;
  }
}

}  // namespace lockstep
