// The first solid shape that each ray meets, and where: all shapes of its world that are in the mask, those first whose
// bounding spheres the ray meets. Of two at one distance the one of smaller index counts. Sensors are not met.
#pragma once

#include "cpu_reference/shapes/rays.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
struct ClosestHit {
  u32 shape;
  RayPoint<real> point;
};

/// Whether the ray passes within `reach` of the point that is at `offset` from its origin; not what is behind it.
template <class real>
bool ray_passes(Vec3<real> offset, Vec3<real> direction, real reach) {
  const real along = dot3(offset, direction);
  const Vec3<real> aside = sub3(offset, scale3(along > 0 ? along : real(0), direction));
  return dot3(aside, aside) <= reach * reach * real(1.0001);
}

template <class real>
ClosestHit<real> cast_ray(const Buffers<real>& b, const Ray<real>& ray, const QueryFilter& filter) {
  const HullTables<real> tables = {b.hulls.data(),      b.hull_vertices.data(), b.hull_planes.data(),
                                   b.hull_faces.data(), b.hull_edges.data(),    b.hull_corners.data()};
  const Vec3<real> origin = vec3(ray.origin), direction = vec3(ray.direction);
  const WorldRange& world = b.world_ranges[filter.world];
  ClosestHit<real> closest = {NONE, {{0, 0, 0}, 0}};
  for (u32 i = world.first_shape; i < world.first_shape + world.shape_count; ++i) {
    const ShapeInfo& info = b.shape_infos[i];
    if ((info.category & filter.mask) == 0 || (info.flags & SHAPE_IS_SENSOR) != 0) continue;
    const Pose<real> pose = make_pose(b.positions[info.body], b.orientations[info.body]);
    const Vec3<real> offset = sub3(shape_center(pose, b.shapes[i]), origin);
    if (info.kind != SHAPE_PLANE && !ray_passes(offset, direction, b.shapes[i].reach)) continue;
    const Quat<real> turn = shape_rotation(pose, b.shapes[i]);
    const RayEntry<real> entry = ray_shape(info.kind, unrotate3(turn, scale3(real(-1), offset)),
                                           unrotate3(turn, direction), vec3(b.shapes[i].size), info.hull, tables);
    const bool first = closest.shape == NONE || entry.distance < closest.point.distance;
    if (!(entry.distance >= 0 && entry.distance <= ray.reach) || !first) continue;
    const Vec3<real> normal = rotate3(turn, entry.normal);
    closest = {i, {{normal.x, normal.y, normal.z}, entry.distance}};
  }
  return closest;
}

/// What is behind the last ray is told to meet nothing.
template <class real>
void cast_rays(Buffers<real>& b, const StepParams<real>& params) {
  for (u32 i = 0; i < b.rays.size(); ++i) {
    const ClosestHit<real> hit =
        i < params.queries ? cast_ray(b, b.rays[i], b.ray_filters[i]) : ClosestHit<real>{NONE, {{0, 0, 0}, 0}};
    b.ray_shapes[i] = hit.shape;
    b.ray_points[i] = hit.point;
  }
}

}  // namespace lockstep::reference
