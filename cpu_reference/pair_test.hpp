// The broad phase's test of a pair, the same for the grid and the tree, so that both find the same pairs: two shapes
// are one if neither their bounding spheres nor their boxes say that they stay apart for the step.
//   spheres   |c_i - c_j| - (r_i + r_j) <= h |v_i - v_j|, v the velocity of the centre: the relative speed, so that a
//             cloud that falls as one makes no pairs
//   boxes     |c_i - c_j|_k <= e_i,k + e_j,k + h (|v_i - v_j|_k + s_i + s_j) on each axis k of the world, with half
//             extents e and what rotation adds to a point's speed, s = |w| r; not asked where both are spheres
//   a plane   gap of the bounding sphere <= h max(0, approach speed)
// The radii r and half extents e have margins around them (shape_bound.hpp).
// kernels/pair_search.h is the twin.
#pragma once

#include <algorithm>
#include <vector>

#include "cpu_reference/shapes/may_touch.hpp"
#include "cpu_reference/shapes/sphere_plane.hpp"
#include "cpu_reference/sleep.hpp"
#include "cpu_reference/tolerances.hpp"
#include "cpu_reference/top_level_shapes.hpp"

namespace lockstep::reference {

/// A shape, and where it stays for the step.
template <class real>
struct Bounded {
  u32 shape;
  Bound<real> bound;
  Vec3<real> center() const { return vec3(bound.center); }
};

/// The k-th of those that the broad phase looks at.
template <class real>
Bounded<real> top_level(const Buffers<real>& b, u32 k) {
  return {top_level_shape(b, k), b.bounds[k]};
}

template <class real>
Vec3<real> body_position(const Buffers<real>& b, u32 body) {
  return {b.positions[body].x, b.positions[body].y, b.positions[body].z};
}

template <class real>
Vec3<real> center_velocity(const Buffers<real>& b, const Bounded<real>& of) {
  const u32 body = b.shape_infos[of.shape].body;
  return point_velocity(b.motions[body], sub3(of.center(), body_position(b, body)));
}

/// How fast rotation alone can move a point of the shape; of a sphere it moves none out of the sphere.
template <class real>
real rotational_speed_of(const Buffers<real>& b, const Bounded<real>& of) {
  const ShapeInfo& info = b.shape_infos[of.shape];
  return info.kind == SHAPE_SPHERE ? real(0) : length3(vec3(b.motions[info.body].w)) * of.bound.bounding_radius;
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

/// The gap along one axis can close: distance and relative velocity d and u of the centres, half extents and rotational
/// speeds of both together.
template <class real>
bool axis_in_range(const StepParams<real>& params, real d, real u, real half, real rotational_speed) {
  return std::abs(d) <= half + step_length(params) * (std::abs(u) + rotational_speed);
}

/// Symmetric to the last bit: a search may find a pair from either side.
template <class real>
bool shapes_in_range(const Buffers<real>& b, const StepParams<real>& params, const Bounded<real>& one,
                     const Bounded<real>& two) {
  const Bound<real>&mine = one.bound, &other = two.bound;
  const Vec3<real> d = sub3(one.center(), two.center());
  const Vec3<real> u = sub3(center_velocity(b, one), center_velocity(b, two));
  if (!within_range(params, real(0), length3(d) - (mine.bounding_radius + other.bounding_radius), length3(u)))
    return false;
  if (b.shape_infos[one.shape].kind == SHAPE_SPHERE && b.shape_infos[two.shape].kind == SHAPE_SPHERE) return true;
  const real rotational_speed = rotational_speed_of(b, one) + rotational_speed_of(b, two);
  return axis_in_range(params, d.x, u.x, mine.box[0] + other.box[0], rotational_speed) &&
         axis_in_range(params, d.y, u.y, mine.box[1] + other.box[1], rotational_speed) &&
         axis_in_range(params, d.z, u.z, mine.box[2] + other.box[2], rotational_speed);
}

/// Whether two bounded shapes are a pair.
template <class real>
bool are_pair(const Buffers<real>& b, const StepParams<real>& params, const Bounded<real>& one,
              const Bounded<real>& two) {
  return two.bound.extent > 0 && is_pair(b, one.shape, two.shape) && shapes_in_range(b, params, one, two);
}

template <class real>
bool plane_in_range(const Buffers<real>& b, const StepParams<real>& params, const Bounded<real>& of, u32 plane) {
  const u32 body_i = b.shape_infos[of.shape].body, body_p = b.shape_infos[plane].body;
  const Pose<real> pose = make_pose(b.positions[body_p], b.orientations[body_p]);
  const Vec3<real> center = of.center(), point = shape_center(pose, b.shapes[plane]);
  const Vec3<real> normal = plane_normal(shape_rotation(pose, b.shapes[plane]));
  const real bounding_radius = of.bound.bounding_radius;
  const real gap = dot3(normal, sub3(center, point)) - bounding_radius;
  const Vec3<real> touch = sub3(center, scale3(bounding_radius, normal));
  const real speed = approach_speed(normal, b.motions[body_i], sub3(touch, body_position(b, body_i)), b.motions[body_p],
                                    sub3(touch, pose.position));
  return within_range(params, shape_margin(params, real(0), real(0)), gap, speed);
}

}  // namespace lockstep::reference
