// Broad phase on a hashed uniform grid (Teschner et al. 2003): pairs of shapes that can touch within the step. The
// bounding spheres i < j are a pair if |c_i - c_j| - r_i - r_j <= margin + h |v_i - v_j|: the relative speed, so that a
// cloud that falls as one makes no pairs. A sphere and a plane are one if their gap <= margin + h max(0, approach
// speed).
#pragma once

#include <algorithm>

#include "cpu_reference/shapes/reach.hpp"
#include "cpu_reference/shapes/sphere_plane.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
Vec3<real> bound_center(const Buffers<real>& b, u32 shape) {
  return {b.bounds[shape].x, b.bounds[shape].y, b.bounds[shape].z};
}

template <class real>
Vec3<real> body_position(const Buffers<real>& b, u32 body) {
  return {b.positions[body].x, b.positions[body].y, b.positions[body].z};
}

template <class real>
bool is_pair(const Buffers<real>& b, u32 i, u32 j) {
  const ShapeInfo &a = b.shape_infos[i], &c = b.shape_infos[j];
  return may_touch(a, c, b.body_infos[a.body], b.body_infos[c.body]);
}

template <class real>
bool spheres_in_reach(const Buffers<real>& b, const StepParams<real>& params, u32 i, u32 j) {
  const Vec3<real> center_i = bound_center(b, i), center_j = bound_center(b, j);
  const u32 body_i = b.shape_infos[i].body, body_j = b.shape_infos[j].body;
  const Vec3<real> velocity_i = point_velocity(b.motions[body_i], sub3(center_i, body_position(b, body_i)));
  const Vec3<real> velocity_j = point_velocity(b.motions[body_j], sub3(center_j, body_position(b, body_j)));
  const real gap = length3(sub3(center_i, center_j)) - b.shapes[i].reach - b.shapes[j].reach;
  return within_reach(params, gap, length3(sub3(velocity_i, velocity_j)));
}

template <class real>
bool plane_in_reach(const Buffers<real>& b, const StepParams<real>& params, u32 i, u32 plane) {
  const u32 body_i = b.shape_infos[i].body, body_p = b.shape_infos[plane].body;
  const Pose<real> pose = make_pose(b.positions[body_p], b.orientations[body_p]);
  const Vec3<real> center = bound_center(b, i), point = shape_center(pose, b.shapes[plane]);
  const Vec3<real> normal = plane_normal(shape_rotation(pose, b.shapes[plane]));
  const real reach = b.shapes[i].reach;
  const real gap = dot3(normal, sub3(center, point)) - reach;
  const Vec3<real> touch = sub3(center, scale3(reach, normal));
  const real speed = approach_speed(normal, b.motions[body_i], sub3(touch, body_position(b, body_i)), b.motions[body_p],
                                    sub3(touch, pose.position));
  return within_reach(params, gap, speed);
}

/// The spheres of larger index that sphere i is paired with.
template <class real>
void search_grid(const Buffers<real>& b, const StepParams<real>& params, u32 i, std::vector<u32>& found) {
  const u32 max_extent = b.counters[COUNTER_MAX_EXTENT];
  const real size = cell_size(params, max_extent);
  const real reach = pair_reach(params, b.bounds[i].w, max_extent);
  const Vec3<real> center = bound_center(b, i);
  const u32 world = b.body_infos[b.shape_infos[i].body].world;
  const i32 low_x = cell_of(center.x - reach, size), high_x = cell_of(center.x + reach, size);
  const i32 low_y = cell_of(center.y - reach, size), high_y = cell_of(center.y + reach, size);
  const i32 low_z = cell_of(center.z - reach, size), high_z = cell_of(center.z + reach, size);
  for (i32 z = low_z; z <= high_z; ++z) {
    for (i32 y = low_y; y <= high_y; ++y) {
      for (i32 x = low_x; x <= high_x; ++x) {
        const u32 bucket = bucket_of(x, row_hash(y, z, world), params.buckets);
        for (u32 k = b.bucket_starts[bucket]; k < b.bucket_starts[bucket + 1]; ++k) {
          const u32 j = b.bucket_items[k];
          const bool in_cell = b.cells[j].x == x && b.cells[j].y == y && b.cells[j].z == z;
          if (j > i && in_cell && is_pair(b, i, j) && spheres_in_reach(b, params, i, j)) found.push_back(j);
        }
      }
    }
  }
}

/// Pairs ordered by (shape_a, shape_b). Where they are more than the capacity none is kept, and the step is void.
template <class real>
void find_pairs(Buffers<real>& b, const StepParams<real>& params) {
  u32 total = 0;
  std::vector<u32> found;
  for (u32 i = 0; i < params.shapes; ++i) {
    found.clear();
    if (b.cells[i].bucket != NONE) {
      search_grid(b, params, i, found);
      const WorldRange& world = b.world_ranges[b.body_infos[b.shape_infos[i].body].world];
      for (u32 k = 0; k < world.plane_count; ++k) {
        const u32 plane = b.planes[world.first_plane + k];
        if (is_pair(b, i, plane) && plane_in_reach(b, params, i, plane)) found.push_back(plane);
      }
      std::sort(found.begin(), found.end());
    }
    b.pair_starts[i] = total;
    for (u32 j : found) {
      if (total < params.pair_capacity) b.pairs[total] = {i, j};
      ++total;
    }
  }
  b.pair_starts[params.shapes] = total;
  b.counters[COUNTER_PAIRS_NEEDED] = total;
  b.counters[COUNTER_PAIRS] = total <= params.pair_capacity ? total : 0;
  if (total > params.pair_capacity) b.counters[COUNTER_STATUS] |= STATUS_PAIRS_FULL;
}

}  // namespace lockstep::reference
