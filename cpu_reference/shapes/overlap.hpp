// Whether two shapes overlap. kernels/shapes/overlap.h is the twin.
#pragma once

#include "cpu_reference/shapes/pairs.hpp"

namespace lockstep::reference {

/// The shape in the axes of the world, moved to `origin`.
template <class real>
WorldShape<real> shape_in_world(const Pose<real>& pose, const Shape<real>& shape, u32 hull, Vec3<real> origin) {
  return {add3(sub3(pose.position, origin), rotate3(pose.orientation, vec3(shape.offset))), shape_rotation(pose, shape),
          vec3(shape.size), hull};
}

template <class real>
bool shapes_overlap(u32 kind_a, const WorldShape<real>& a, u32 kind_b, const WorldShape<real>& b,
                    const HullTables<real>& tables) {
  const Manifold<real> m = collide_shapes(kind_a, a, kind_b, b, tables, real(0));
  for (u32 k = 0; k < m.count; ++k) {
    if (gap_at(m, k) <= 0) return true;
  }
  return false;
}

}  // namespace lockstep::reference
