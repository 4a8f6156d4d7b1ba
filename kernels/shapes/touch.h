// Where shapes stand and how two of them touch. cpu_reference/shapes/touch.hpp is the twin.
#ifndef LOCKSTEP_TOUCH_H
#define LOCKSTEP_TOUCH_H

#include "math.h"

// A body's frame in the world.
typedef struct Pose {
  Vec3 position;
  Quat orientation;
} Pose;

// A shape in the world. A sphere: radius size.x. A plane: through `center`, normal the z axis of `rotation`.
typedef struct Placed {
  Vec3 center;
  Quat rotation;
  Vec3 size;
} Placed;

// Two shapes at one point. The normal points from b to a; the gap is negative where they overlap.
typedef struct Touch {
  Vec3 normal;
  real gap;
  Vec3 point;
} Touch;

static inline Pose make_pose(Vec4 position, Vec4 orientation) {
  Pose pose;
  pose.position = make3(position.x, position.y, position.z);
  pose.orientation = quat(orientation);
  return pose;
}

// The origin of the shape's frame in the world: of a shape at the centre of mass exactly the body's position.
static inline Vec3 shape_center(Pose pose, Shape shape) {
  const Vec3 offset = make3(shape.offset[0], shape.offset[1], shape.offset[2]);
  return add3(pose.position, rotate3(pose.orientation, offset));
}

static inline Placed place_shape(Pose pose, Shape shape) {
  Placed placed;
  placed.center = shape_center(pose, shape);
  placed.rotation =
      multiply4(pose.orientation, make4(shape.rotation[0], shape.rotation[1], shape.rotation[2], shape.rotation[3]));
  placed.size = make3(shape.size[0], shape.size[1], shape.size[2]);
  return placed;
}

#endif
