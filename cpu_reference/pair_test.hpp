// The broad phase's test of a pair, the same for the grid and the tree, so that both find the same pairs: two shapes
// are one if neither their bounding spheres nor their boxes say that they stay apart for the step.
//   spheres   |c_i - c_j| - (r_i + r_j) <= margin + h |v_i - v_j|, v the velocity of the centre: the relative speed, so
//             that a cloud that falls as one makes no pairs
//   boxes     |c_i - c_j|_k <= e_i,k + e_j,k + margin + h (|v_i - v_j|_k + s_i + s_j) on each axis k of the world, with
//             half extents e and what turning adds to a point's speed, s = |w| r; not asked where both are spheres
//   a plane   gap of the bounding sphere <= margin + h max(0, approach speed)
// kernels/pair_search.h is the twin.
#pragma once

#include <algorithm>
#include <vector>

#include "cpu_reference/shapes/reach.hpp"
#include "cpu_reference/shapes/sphere_plane.hpp"
#include "cpu_reference/sleep.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
Vec3<real> bound_center(const Buffers<real>& b, u32 shape) {
  return vec3(b.bounds[shape].center);
}

template <class real>
Vec3<real> body_position(const Buffers<real>& b, u32 body) {
  return {b.positions[body].x, b.positions[body].y, b.positions[body].z};
}

template <class real>
Vec3<real> center_velocity(const Buffers<real>& b, u32 shape) {
  const u32 body = b.shape_infos[shape].body;
  return point_velocity(b.motions[body], sub3(bound_center(b, shape), body_position(b, body)));
}

/// How fast turning alone can move a point of the shape; of a sphere it moves none out of the sphere.
template <class real>
real turning_speed(const Buffers<real>& b, u32 shape) {
  if (b.shape_infos[shape].kind == SHAPE_SPHERE) return 0;
  return length3(vec3(b.motions[b.shape_infos[shape].body].w)) * b.bounds[shape].reach;
}

/// Whether a joint holds the two bodies together and keeps them from colliding.
template <class real>
bool are_joined(const Buffers<real>& b, u32 body_a, u32 body_b) {
  if (b.joined_starts.empty()) return false;
  const u32 *first = b.joined_bodies.data() + b.joined_starts[body_a],
            *last = b.joined_bodies.data() + b.joined_starts[body_a + 1];
  return std::find(first, last, body_b) != last;
}

template <class real>
bool is_pair(const Buffers<real>& b, u32 i, u32 j) {
  const ShapeInfo &a = b.shape_infos[i], &c = b.shape_infos[j];
  if (are_joined(b, a.body, c.body)) return false;
  if (!looks_for_others(b, i) && !looks_for_others(b, j)) return false;
  return may_touch(a, c, b.body_infos[a.body], b.body_infos[c.body]);
}

/// The gap along one axis can close: distance and relative velocity d and u of the centres, half extents and turning
/// speeds of both together.
template <class real>
bool axis_in_reach(const StepParams<real>& params, real d, real u, real half, real turning) {
  return std::abs(d) <= half + params.margin + step_length(params) * (std::abs(u) + turning);
}

/// Symmetric in i and j to the last bit: a search may find a pair from either side.
template <class real>
bool shapes_in_reach(const Buffers<real>& b, const StepParams<real>& params, u32 i, u32 j) {
  const Bound<real>&mine = b.bounds[i], &other = b.bounds[j];
  const Vec3<real> d = sub3(bound_center(b, i), bound_center(b, j));
  const Vec3<real> u = sub3(center_velocity(b, i), center_velocity(b, j));
  if (!within_reach(params, length3(d) - (mine.reach + other.reach), length3(u))) return false;
  if (b.shape_infos[i].kind == SHAPE_SPHERE && b.shape_infos[j].kind == SHAPE_SPHERE) return true;
  const real turning = turning_speed(b, i) + turning_speed(b, j);
  return axis_in_reach(params, d.x, u.x, mine.box[0] + other.box[0], turning) &&
         axis_in_reach(params, d.y, u.y, mine.box[1] + other.box[1], turning) &&
         axis_in_reach(params, d.z, u.z, mine.box[2] + other.box[2], turning);
}

template <class real>
bool plane_in_reach(const Buffers<real>& b, const StepParams<real>& params, u32 i, u32 plane) {
  const u32 body_i = b.shape_infos[i].body, body_p = b.shape_infos[plane].body;
  const Pose<real> pose = make_pose(b.positions[body_p], b.orientations[body_p]);
  const Vec3<real> center = bound_center(b, i), point = shape_center(pose, b.shapes[plane]);
  const Vec3<real> normal = plane_normal(shape_rotation(pose, b.shapes[plane]));
  const real reach = b.bounds[i].reach;
  const real gap = dot3(normal, sub3(center, point)) - reach;
  const Vec3<real> touch = sub3(center, scale3(reach, normal));
  const real speed = approach_speed(normal, b.motions[body_i], sub3(touch, body_position(b, body_i)), b.motions[body_p],
                                    sub3(touch, pose.position));
  return within_reach(params, gap, speed);
}

/// Makes the list of pairs, ordered by (shape_a, shape_b). `search(i, found)` appends the bounded shapes of larger
/// index that the bounded shape i is paired with, and says whether i takes part at all. Where pairs are more than the
/// capacity none is kept, and the step is void.
template <class real, class Search>
void list_pairs(Buffers<real>& b, const StepParams<real>& params, Search&& search) {
  u32 total = 0;
  std::vector<u32> found;
  for (u32 i = 0; i < params.shapes; ++i) {
    found.clear();
    if (b.bounds[i].extent > 0 && search(i, found)) {
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
