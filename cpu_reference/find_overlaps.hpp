// The solid shapes that overlap each volume, a sphere or a box in the world: all shapes of its world that are in the
// mask, in order of index, those first whose bounding spheres overlap. Triggers are not told.
#pragma once

#include <algorithm>

#include "cpu_reference/shapes/overlap.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// Shapes are moved to the centre of the volume.
template <class real>
bool volume_overlaps(const Buffers<real>& b, const Shape<real>& volume, const QueryFilter& filter, u32 i) {
  const ShapeInfo& info = b.shape_infos[i];
  const Shape<real>& shape = b.shapes[i];
  if ((info.category & filter.mask) == 0 || (info.flags & SHAPE_IS_TRIGGER) != 0) return false;
  const Pose<real> pose = make_pose(b.positions[info.body], b.orientations[info.body]);
  const WorldShape<real> other = shape_in_world(pose, shape, info.hull, vec3(volume.offset));
  const real range = (volume.bounding_radius + shape.bounding_radius) * real(1.0001);
  if (info.kind != SHAPE_PLANE && dot3(other.center, other.center) > range * range) return false;
  const HullTables<real> tables = {b.hulls.data(),      b.hull_vertices.data(), b.hull_planes.data(),
                                   b.hull_faces.data(), b.hull_edges.data(),    b.hull_corners.data(),
                                   b.facets.data(),     b.facet_edges.data()};
  const Quat<real> rotation = {volume.rotation[0], volume.rotation[1], volume.rotation[2], volume.rotation[3]};
  return shapes_overlap(filter.kind, WorldShape<real>{{0, 0, 0}, rotation, vec3(volume.size), 0}, info.kind, other,
                        tables);
}

/// Where there are more than the capacity none is told. What is behind the last one is told to be NONE.
template <class real>
void find_overlaps(Buffers<real>& b, const StepParams<real>& params) {
  std::vector<u32> found;
  for (u32 v = 0; v < b.volumes.size(); ++v) {
    b.overlap_starts[v] = static_cast<u32>(found.size());
    if (v >= params.queries) continue;
    const WorldRange& world = b.world_ranges[b.volume_filters[v].world];
    for (u32 i = world.first_shape; i < world.first_shape + world.shape_count; ++i) {
      if (volume_overlaps(b, b.volumes[v], b.volume_filters[v], i)) found.push_back(i);
    }
  }
  b.overlap_starts[b.volumes.size()] = static_cast<u32>(found.size());
  if (found.size() > params.overlap_capacity) found.clear();
  std::fill(std::copy(found.begin(), found.end(), b.overlaps.begin()), b.overlaps.end(), NONE);
}

}  // namespace lockstep::reference
