// Where a shape is, and where it stays for a whole step of length h at its present velocity.
//   sphere  centre c, extent r + h (|v| + |w| |c - x|), with r the bounding radius and x the centre of mass: for the
//   whole step.
//           The grid's cells are sized by the largest extent.
//   box     half extents along the axes of the world, of the shape where it is now: its support in the three
//           directions (Ericson, Real-Time Collision Detection, 2005, section 4.2.6).
// kernels/shape_bound.h is the twin.
#pragma once

#include "cpu_reference/grid.hpp"
#include "cpu_reference/tolerances.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// Covers the rounding of the rotation.
template <class real>
constexpr real bound_slack = real(1.00001);

/// |R| size, with R the rotation matrix: for a box along the axes of the shape.
template <class real>
Vec3<real> box_half(Quat<real> rotation, Vec3<real> size) {
  const Vec3<real> x = absolute3(rotate3(rotation, Vec3<real>{size.x, 0, 0}));
  const Vec3<real> y = absolute3(rotate3(rotation, Vec3<real>{0, size.y, 0}));
  const Vec3<real> z = absolute3(rotate3(rotation, Vec3<real>{0, 0, size.z}));
  return add3(add3(x, y), z);
}

/// A segment of half length l along the axis a, swept by a sphere (capsule): l |a_k| + r, or by a disc across it
/// (cylinder): l |a_k| + r sqrt(1 - a_k^2), the root written as that of the other two squares, which loses nothing
/// where the axis is along k.
template <class real>
Vec3<real> round_half(u32 kind, Vec3<real> axis, real radius, real half_length) {
  const Vec3<real> along = scale3(half_length, absolute3(axis));
  if (kind == SHAPE_CAPSULE) return add3(along, Vec3<real>{radius, radius, radius});
  const Vec3<real> square = {axis.x * axis.x, axis.y * axis.y, axis.z * axis.z};
  const Vec3<real> across = {std::sqrt(square.y + square.z), std::sqrt(square.x + square.z),
                             std::sqrt(square.x + square.y)};
  return add3(along, scale3(radius, across));
}

template <class real>
Vec3<real> shape_half(u32 kind, const Shape<real>& shape, Quat<real> rotation) {
  if (kind == SHAPE_BOX || kind == SHAPE_HULL) return scale3(bound_slack<real>, box_half(rotation, vec3(shape.size)));
  if (kind == SHAPE_CAPSULE || kind == SHAPE_CYLINDER) {
    const Vec3<real> axis = rotate3(rotation, Vec3<real>{0, 0, 1});
    return scale3(bound_slack<real>, round_half(kind, axis, shape.size[0], shape.size[1]));
  }
  return {shape.bounding_radius, shape.bounding_radius, shape.bounding_radius};
}

/// The bound of a shape, its margin around it; planes have extent 0, and all of it is 0 where the shape has no finite
/// position. Returns whether it has one.
template <class real>
bool shape_bound(const Buffers<real>& b, const StepParams<real>& params, u32 i, Bound<real>& bound) {
  const u32 body = b.shape_infos[i].body, kind = b.shape_infos[i].kind;
  const Shape<real>& shape = b.shapes[i];
  const Motion<real>& motion = b.motions[body];
  const Pose<real> pose = make_pose(b.positions[body], b.orientations[body]);
  const Vec3<real> center = shape_center(pose, shape);
  const real displacement = shape_displacement(step_length(params), point_velocity(motion, sub3(center, pose.position)),
                                               motion, shape.bounding_radius);
  const real margin = shape_margin(
      params, used_margin(own_margin(params, shape.bounding_radius, shape.size[3]), displacement), motion.inverse_mass);
  const real bounding_radius = shape.bounding_radius + margin;
  const Vec3<real> half =
      add3(shape_half(kind, shape, shape_rotation(pose, shape)), Vec3<real>{margin, margin, margin});
  real extent = 0;
  if (kind != SHAPE_PLANE) {
    const real arm = length3(sub3(center, pose.position));
    const real speed = length3(vec3(motion.v)) + length3(vec3(motion.w)) * arm;
    extent = bounding_radius + step_length(params) * speed;
  }
  const bool finite = is_finite(center.x) && is_finite(center.y) && is_finite(center.z) && is_finite(extent) &&
                      is_finite(half.x) && is_finite(half.y) && is_finite(half.z);
  bound = {};
  if (finite) bound = {{center.x, center.y, center.z}, extent, {half.x, half.y, half.z}, bounding_radius};
  return finite;
}

}  // namespace lockstep::reference
