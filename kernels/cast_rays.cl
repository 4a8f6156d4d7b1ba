#pragma OPENCL FP_CONTRACT OFF
// The first solid shape that each ray meets (cpu_reference/cast_rays.hpp).
#include "common.h"
#include "shapes/rays.h"
#include "types.h"

// Whether the ray passes within `reach` of the point that is at `offset` from its origin; not what is behind it.
static inline bool ray_passes(Vec3 offset, Vec3 direction, real reach) {
  const real along = dot3(offset, direction);
  const Vec3 aside = sub3(offset, scale3(along > (real)0 ? along : (real)0, direction));
  return dot3(aside, aside) <= reach * reach * (real)1.0001;
}

// `room`: rays that the buffers hold.
kernel void cast_rays(global const WorldRange* world_ranges, global const ShapeInfo* shape_infos,
                      global const Shape* shapes, global const Vec4* positions, global const Vec4* orientations,
                      global const Hull* hulls, global const Vec4* hull_vertices, global const Vec4* hull_planes,
                      global const HullFace* hull_faces, global const HullEdge* hull_edges,
                      global const u32* hull_corners, global const Ray* rays, global const QueryFilter* ray_filters,
                      global u32* ray_shapes, global RayPoint* ray_points, const u32 room, const StepParams params) {
  const HullTables tables = {hulls, hull_vertices, hull_planes, hull_faces, hull_edges, hull_corners};
  FOR_EACH(r, room) {
    u32 closest = NONE;
    real distance = (real)0;
    Vec3 normal = make3((real)0, (real)0, (real)0);
    if (r < params.queries) {
      const Ray ray = rays[r];
      const QueryFilter filter = ray_filters[r];
      const Vec3 origin = make3(ray.origin[0], ray.origin[1], ray.origin[2]);
      const Vec3 direction = make3(ray.direction[0], ray.direction[1], ray.direction[2]);
      const WorldRange world = world_ranges[filter.world];
      for (u32 i = world.first_shape; i < world.first_shape + world.shape_count; ++i) {
        const ShapeInfo info = shape_infos[i];
        if ((info.category & filter.mask) == 0u || (info.flags & SHAPE_IS_SENSOR) != 0u) continue;
        const Pose pose = make_pose(positions[info.body], orientations[info.body]);
        const Vec3 offset = sub3(shape_center(pose, shapes + i), origin);
        if (info.kind != SHAPE_PLANE && !ray_passes(offset, direction, shapes[i].reach)) continue;
        const Quat turn = shape_rotation(pose, shapes + i);
        const Vec3 size = make3(shapes[i].size[0], shapes[i].size[1], shapes[i].size[2]);
        const RayEntry entry = ray_shape(info.kind, unrotate3(turn, scale3((real)-1, offset)),
                                         unrotate3(turn, direction), size, info.hull, tables);
        const bool first = closest == NONE || entry.distance < distance;
        if (!(entry.distance >= (real)0 && entry.distance <= ray.reach) || !first) continue;
        closest = i;
        distance = entry.distance;
        normal = rotate3(turn, entry.normal);
      }
    }
    ray_shapes[r] = closest;
    ray_points[r].normal[0] = normal.x;
    ray_points[r].normal[1] = normal.y;
    ray_points[r].normal[2] = normal.z;
    ray_points[r].distance = distance;
  }
}
