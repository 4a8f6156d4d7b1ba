// The first solid shape that each ray meets, and where: all shapes of its world that are in the mask, those first whose
// bounding spheres the ray meets; those of trees (cpu_reference/shape_trees.hpp) where it meets their boxes. Of two at
// one distance the one of smaller index counts. Triggers are not met.
#pragma once

#include <algorithm>

#include "cpu_reference/shapes/rays.hpp"
#include "cpu_reference/tree.hpp"

namespace lockstep::reference {

template <class real>
struct ClosestHit {
  u32 shape;
  RayPoint<real> point;
};

/// Whether the ray passes within `range` of the point that is at `offset` from its origin; not what is behind it.
template <class real>
bool ray_passes(Vec3<real> offset, Vec3<real> direction, real range) {
  const real along = dot3(offset, direction);
  const Vec3<real> aside = sub3(offset, scale3(along > 0 ? along : real(0), direction));
  return dot3(aside, aside) <= range * range * real(1.0001);
}

/// A ray on its way through a world.
template <class real>
struct RayCast {
  const Buffers<real>& b;
  const Ray<real>& ray;
  const QueryFilter& filter;
  ClosestHit<real> closest = {NONE, {{0, 0, 0}, 0}};

  /// Looks whether the ray meets shape i before what it has met so far.
  void meet_shape(u32 i) {
    const HullTables<real> tables = {b.hulls.data(),      b.hull_vertices.data(), b.hull_planes.data(),
                                     b.hull_faces.data(), b.hull_edges.data(),    b.hull_corners.data(),
                                     b.facets.data(),     b.facet_edges.data()};
    const Vec3<real> origin = vec3(ray.origin), direction = vec3(ray.direction);
    const ShapeInfo& info = b.shape_infos[i];
    if ((info.category & filter.mask) == 0 || (info.flags & SHAPE_IS_TRIGGER) != 0) return;
    const Pose<real> pose = make_pose(b.positions[info.body], b.orientations[info.body]);
    const Vec3<real> offset = sub3(shape_center(pose, b.shapes[i]), origin);
    if (info.kind != SHAPE_PLANE && !ray_passes(offset, direction, b.shapes[i].bounding_radius)) return;
    const Quat<real> rotation = shape_rotation(pose, b.shapes[i]);
    const RayEntry<real> entry = ray_shape(info.kind, unrotate3(rotation, scale3(real(-1), offset)),
                                           unrotate3(rotation, direction), vec3(b.shapes[i].size), info.hull, tables);
    const bool first = closest.shape == NONE || entry.distance < closest.point.distance ||
                       (entry.distance == closest.point.distance && i < closest.shape);
    if (!(entry.distance >= 0 && entry.distance <= ray.range) || !first) return;
    const Vec3<real> normal = rotate3(rotation, entry.normal);
    closest = {i, {{normal.x, normal.y, normal.z}, entry.distance}};
  }

  /// The same for the shapes of a tree, of which the boxes on the way of the ray tell.
  void meet_tree(const ShapeTree<real>& tree) {
    const Pose<real> pose = make_pose(b.positions[tree.body], b.orientations[tree.body]);
    const Vec3<real> d = sub3(vec3(ray.origin), pose.position), origin = unrotate3(pose.orientation, d);
    const Vec3<real> direction = unrotate3(pose.orientation, vec3(ray.direction)), at = pose.position;
    const real rounding = sizeof(real) == 4 ? real(2e-6) : real(4e-15);
    const real wider = (std::abs(at.x) + std::abs(at.y) + std::abs(at.z) + std::abs(d.x) + std::abs(d.y) +
                        std::abs(d.z) + tree.radius) *
                       rounding;
    const auto meets = [&](const BoxBlock<real>& block, u32 k) {
      const real low[] = {block.low_x[k], block.low_y[k], block.low_z[k]};
      const real high[] = {block.high_x[k], block.high_y[k], block.high_z[k]};
      const real from[] = {origin.x, origin.y, origin.z}, to[] = {direction.x, direction.y, direction.z};
      real enters = real(-1e37), leaves = real(1e37);
      for (u32 axis = 0; axis < 3; ++axis) {
        const real inverse = real(1) / to[axis];
        const real one = (low[axis] - (from[axis] + wider)) * inverse;
        const real two = (high[axis] - (from[axis] - wider)) * inverse;
        enters = std::max(std::min(two, one), enters);  // what is no number does not count
        leaves = std::min(std::max(two, one), leaves);
      }
      const real range = (closest.shape == NONE ? ray.range : closest.point.distance) * real(1.0001);
      return enters <= leaves && leaves >= 0 && enters <= range;
    };
    traverse_tree(b.shape_tree_blocks.data() + tree.first_block, tree.item_count, meets,
                  [&](u32 entry) { meet_shape(b.shape_tree_items[tree.first_item + entry]); });
  }
};

template <class real>
ClosestHit<real> cast_ray(const Buffers<real>& b, const Ray<real>& ray, const QueryFilter& filter) {
  RayCast<real> cast = {b, ray, filter};
  const auto [first, count] = top_level_range(b, filter.world);
  for (u32 k = first; k < first + count; ++k) cast.meet_shape(top_level_shape(b, k));
  if (b.world_trees.empty()) return cast.closest;
  const WorldTrees& world = b.world_trees[filter.world];
  for (u32 t = world.first_tree; t < world.first_tree + world.tree_count; ++t) cast.meet_tree(b.shape_trees[t]);
  return cast.closest;
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
