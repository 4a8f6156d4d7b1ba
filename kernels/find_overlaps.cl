#pragma OPENCL FP_CONTRACT OFF
// The solid shapes that overlap each volume (cpu_reference/find_overlaps.hpp).
#include "common.h"
#include "shapes/overlap.h"
#include "types.h"

static inline bool volume_overlaps(global const Shape* volume, QueryFilter filter, u32 i,
                                   global const ShapeInfo* shape_infos, global const Shape* shapes,
                                   global const Vec4* positions, global const Vec4* orientations,
                                   const HullTables* tables) {
  const ShapeInfo info = shape_infos[i];
  if ((info.category & filter.mask) == 0u || (info.flags & SHAPE_IS_TRIGGER) != 0u) return false;
  const Pose pose = make_pose(positions[info.body], orientations[info.body]);
  const Vec3 origin = make3(volume->offset[0], volume->offset[1], volume->offset[2]);
  const WorldShape other = shape_in_world(pose, shapes + i, info.hull, origin);
  const real range = (volume->bounding_radius + shapes[i].bounding_radius) * (real)1.0001;
  if (info.kind != SHAPE_PLANE && dot3(other.center, other.center) > range * range) return false;
  WorldShape world_shape;
  world_shape.center = make3((real)0, (real)0, (real)0);
  world_shape.rotation = make4(volume->rotation[0], volume->rotation[1], volume->rotation[2], volume->rotation[3]);
  world_shape.size = make3(volume->size[0], volume->size[1], volume->size[2]);
  world_shape.hull = 0u;
  world_shape.alone = false;
  world_shape.displacement = world_shape.angular_displacement = make3((real)0, (real)0, (real)0);
  world_shape.margin = world_shape.lag = (real)0;
#if FEATURE_SEAMS
  world_shape.first_seam = world_shape.seam_count = 0u;
#endif
  return shapes_overlap(filter.kind, &world_shape, info.kind, &other, tables);
}

// Counts, or, after the scan of overlap_starts, writes. `room`: volumes that the buffers hold; `overlap_room`: shapes
// that the list holds, 0 to count.
kernel void find_overlaps(global const WorldRange* world_ranges, global const ShapeInfo* shape_infos,
                          global const Shape* shapes, global const Vec4* positions, global const Vec4* orientations,
                          global const Hull* hulls, global const Vec4* hull_vertices, global const Vec4* hull_planes,
                          global const HullFace* hull_faces, global const HullEdge* hull_edges,
                          global const u32* hull_corners, global const Facet* facets,
                          global const FacetEdge* facet_edges, global const Shape* volumes,
                          global const QueryFilter* volume_filters, global u32* overlap_starts, global u32* overlaps,
                          const u32 room, const u32 overlap_room, const StepParams params) {
  const HullTables tables = {hulls,      hull_vertices, hull_planes, hull_faces,
                             hull_edges, hull_corners,  facets,      facet_edges};
  const bool writes = overlap_room > 0u;
  const u32 total = writes ? overlap_starts[room] : 0u;
  const bool full = total > params.overlap_capacity;
  if (writes) {
    FOR_EACH(i, overlap_room) {
      if (full || i >= total) overlaps[i] = NONE;
    }
  }
  FOR_EACH(v, room + 1u) {
    u32 count = 0u;
    if (v < params.queries && v < room && !full) {
      const WorldRange world = world_ranges[volume_filters[v].world];
      for (u32 i = world.first_shape; i < world.first_shape + world.shape_count; ++i) {
        if (!volume_overlaps(volumes + v, volume_filters[v], i, shape_infos, shapes, positions, orientations, &tables))
          continue;
        if (writes) overlaps[overlap_starts[v] + count] = i;
        ++count;
      }
    }
    if (!writes) overlap_starts[v] = count;
  }
}
