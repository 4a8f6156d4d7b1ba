// Whether two shapes overlap. cpu_reference/shapes/overlap.hpp is the twin.
#ifndef LOCKSTEP_OVERLAP_H
#define LOCKSTEP_OVERLAP_H

#include "shapes/pairs.h"

// The shape in the axes of the world, moved to `origin`.
static inline Placed place_shape(Pose pose, global const Shape* shape, u32 hull, Vec3 origin) {
  Placed placed;
  placed.center = add3(sub3(pose.position, origin),
                       rotate3(pose.orientation, make3(shape->offset[0], shape->offset[1], shape->offset[2])));
  placed.rotation = shape_rotation(pose, shape);
  placed.size = make3(shape->size[0], shape->size[1], shape->size[2]);
  placed.hull = hull;
  placed.alone = false;
  placed.way = placed.angular_displacement = make3((real)0, (real)0, (real)0);
  placed.margin = (real)0;
  return placed;
}

static inline bool shapes_overlap(u32 kind_a, Placed a, u32 kind_b, Placed b, HullTables tables) {
  const Manifold m = collide_shapes(kind_a, a, kind_b, b, tables, (real)0);
  bool overlap = false;
  for (u32 k = 0u; k < m.count; ++k) overlap = overlap || gap_at(&m, k) <= (real)0;
  return overlap;
}

#endif
