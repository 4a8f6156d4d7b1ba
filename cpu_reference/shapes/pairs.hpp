// The dispatch over shape pairs. kernels/shapes/pairs.h is the twin.
#pragma once

#include "cpu_reference/shapes/box_box.hpp"
#include "cpu_reference/shapes/box_round.hpp"
#include "cpu_reference/shapes/capsule_box.hpp"
#include "cpu_reference/shapes/capsules.hpp"
#include "cpu_reference/shapes/patch_pairs.hpp"
#include "cpu_reference/shapes/seam_pairs.hpp"
#include "cpu_reference/shapes/sphere_cylinder.hpp"
#include "cpu_reference/shapes/sphere_hull.hpp"
#include "cpu_reference/shapes/sphere_plane.hpp"
#include "cpu_reference/shapes/sphere_sphere.hpp"

namespace lockstep::reference {

/// Kinds in order: kind_a <= kind_b. Points farther apart than `limit` (m) may be left out.
template <class real>
Manifold<real> collide_ordered(u32 kind_a, const WorldShape<real>& a, u32 kind_b, const WorldShape<real>& b,
                               [[maybe_unused]] const HullTables<real>& tables, [[maybe_unused]] real limit) {
#define SHAPE_PAIR(first, second, manifold) \
  if (kind_a == SHAPE_##first && kind_b == SHAPE_##second) return manifold;
#define PATCH_PAIR(first, second) \
  if (kind_a == SHAPE_##first && kind_b == SHAPE_##second) return patches_touch(kind_a, a, kind_b, b, tables, limit);
#include "kernels/shape_pairs.def"
#undef SHAPE_PAIR
#undef PATCH_PAIR
  return no_manifold<real>();
}

template <class real>
Manifold<real> collide_over_seams(u32 kind_a, const WorldShape<real>& a, u32 kind_b, const WorldShape<real>& b,
                                  const HullTables<real>& tables, real limit) {
  const Manifold<real> m = collide_ordered(kind_a, a, kind_b, b, tables, limit);
  return seams_cover_all(kind_a, a, kind_b, b, tables, m) ? touch_over_seams(kind_a, a, kind_b, b, tables, limit) : m;
}

template <class real>
Manifold<real> collide_shapes(u32 kind_a, const WorldShape<real>& a, u32 kind_b, const WorldShape<real>& b,
                              const HullTables<real>& tables, real limit) {
  if (kind_a <= kind_b) return collide_over_seams(kind_a, a, kind_b, b, tables, limit);
  return flipped(collide_over_seams(kind_b, b, kind_a, a, tables, limit));
}

}  // namespace lockstep::reference
