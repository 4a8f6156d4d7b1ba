// Whether two shapes overlap. cpu_reference/shapes/overlap.hpp is the twin.
#ifndef LOCKSTEP_OVERLAP_H
#define LOCKSTEP_OVERLAP_H

#include "shapes/pairs.h"

// The shape in the axes of the world, moved to `origin`.
static inline WorldShape shape_in_world(Pose pose, global const Shape* shape, u32 hull, Vec3 origin) {
  WorldShape world_shape;
  world_shape.center = add3(sub3(pose.position, origin),
                            rotate3(pose.orientation, make3(shape->offset[0], shape->offset[1], shape->offset[2])));
  world_shape.rotation = shape_rotation(pose, shape);
  world_shape.size = make3(shape->size[0], shape->size[1], shape->size[2]);
  world_shape.hull = hull;
  world_shape.alone = false;
  world_shape.displacement = world_shape.angular_displacement = make3((real)0, (real)0, (real)0);
  world_shape.margin = world_shape.lag = (real)0;
#if FEATURE_SEAMS
  world_shape.first_seam = world_shape.seam_count = 0u;
#endif
  return world_shape;
}

static inline bool shapes_overlap(u32 kind_a, const WorldShape* a, u32 kind_b, const WorldShape* b,
                                  const HullTables* tables) {
  const Manifold m = collide_shapes(kind_a, a, kind_b, b, tables, (real)0);
  bool overlap = false;
  for (u32 k = 0u; k < m.count; ++k) overlap = overlap || gap_at(&m, k) <= (real)0;
  return overlap;
}

#endif
