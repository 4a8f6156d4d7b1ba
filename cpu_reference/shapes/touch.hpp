// Where shapes stand and how two of them touch. kernels/shapes/touch.h is the twin.
#pragma once

#include "cpu_reference/math.hpp"

namespace lockstep::reference {

/// A body's frame in the world.
template <class real>
struct Pose {
  Vec3<real> position;
  Quat<real> orientation;
};

/// A shape in the world. A sphere: radius size.x. A plane: through `center`, normal the z axis of `rotation`.
template <class real>
struct Placed {
  Vec3<real> center;
  Quat<real> rotation;
  Vec3<real> size;
};

/// Two shapes at one point. The normal points from b to a; the gap is negative where they overlap.
template <class real>
struct Touch {
  Vec3<real> normal;
  real gap;
  Vec3<real> point;
};

template <class real>
Pose<real> make_pose(Vec4<real> position, Vec4<real> orientation) {
  return {{position.x, position.y, position.z}, quat(orientation)};
}

/// The origin of the shape's frame in the world: of a shape at the centre of mass exactly the body's position.
template <class real>
Vec3<real> shape_center(const Pose<real>& pose, const Shape<real>& shape) {
  return add3(pose.position, rotate3(pose.orientation, vec3(shape.offset)));
}

template <class real>
Placed<real> place_shape(const Pose<real>& pose, const Shape<real>& shape) {
  const Quat<real> rotation = {shape.rotation[0], shape.rotation[1], shape.rotation[2], shape.rotation[3]};
  return {shape_center(pose, shape), multiply4(pose.orientation, rotation), vec3(shape.size)};
}

}  // namespace lockstep::reference
