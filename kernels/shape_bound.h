// Where a shape is, and where it stays for a whole step. cpu_reference/shape_bound.hpp is the twin and says how.
#ifndef LOCKSTEP_SHAPE_BOUND_H
#define LOCKSTEP_SHAPE_BOUND_H

#include "grid.h"
#include "shapes/manifold.h"
#include "tolerances.h"

#if FEATURE_MANIFOLDS

#define BOUND_SLACK ((real)1.00001)

static inline Vec3 box_half(Quat rotation, Vec3 size) {
  const Vec3 x = absolute3(rotate3(rotation, make3(size.x, (real)0, (real)0)));
  const Vec3 y = absolute3(rotate3(rotation, make3((real)0, size.y, (real)0)));
  const Vec3 z = absolute3(rotate3(rotation, make3((real)0, (real)0, size.z)));
  return add3(add3(x, y), z);
}

static inline Vec3 round_half(u32 kind, Vec3 axis, real radius, real half_length) {
  const Vec3 along = scale3(half_length, absolute3(axis));
  if (kind == SHAPE_CAPSULE) return add3(along, make3(radius, radius, radius));
  const Vec3 square = make3(axis.x * axis.x, axis.y * axis.y, axis.z * axis.z);
  const Vec3 across = make3(sqrt(square.y + square.z), sqrt(square.x + square.z), sqrt(square.x + square.y));
  return add3(along, scale3(radius, across));
}

static inline Vec3 shape_half(u32 kind, global const Shape* shape, Quat rotation) {
  if (kind == SHAPE_BOX || kind == SHAPE_HULL)
    return scale3(BOUND_SLACK, box_half(rotation, make3(shape->size[0], shape->size[1], shape->size[2])));
  if (kind == SHAPE_CAPSULE || kind == SHAPE_CYLINDER) {
    const Vec3 axis = rotate3(rotation, make3((real)0, (real)0, (real)1));
    return scale3(BOUND_SLACK, round_half(kind, axis, shape->size[0], shape->size[1]));
  }
  return make3(shape->bounding_radius, shape->bounding_radius, shape->bounding_radius);
}

#endif

// Returns whether the shape has a finite position; all of its bound is 0 where it has none.
static inline bool shape_bound(u32 kind, global const Shape* shape, global const Vec4* position,
                               global const Vec4* orientation, global const Motion* motion, const StepParams* params,
                               Bound* bound) {
  const Pose pose = make_pose(*position, *orientation);
  const Vec3 center = shape_center(pose, shape);
  const real displacement = shape_displacement(step_length(params), point_velocity(motion, sub3(center, pose.position)),
                                               motion, shape->bounding_radius);
  const real margin =
      shape_margin(params, used_margin(own_margin(params, shape->bounding_radius, shape->size[3]), displacement),
                   motion->inverse_mass);
  const real bounding_radius = shape->bounding_radius + margin;
#if FEATURE_MANIFOLDS
  const Vec3 half_extents = add3(shape_half(kind, shape, shape_rotation(pose, shape)), make3(margin, margin, margin));
#else
  const Vec3 half_extents = make3(bounding_radius, bounding_radius, bounding_radius);
#endif
  real extent = (real)0;
  if (kind != SHAPE_PLANE) {
    const Vec3 v = make3(motion->v[0], motion->v[1], motion->v[2]);
    const Vec3 w = make3(motion->w[0], motion->w[1], motion->w[2]);
    const real speed = length3(v) + length3(w) * length3(sub3(center, pose.position));
    extent = bounding_radius + step_length(params) * speed;
  }
  const bool finite = is_finite(center.x) && is_finite(center.y) && is_finite(center.z) && is_finite(extent) &&
                      is_finite(half_extents.x) && is_finite(half_extents.y) && is_finite(half_extents.z);
  bound->center[0] = finite ? center.x : (real)0;
  bound->center[1] = finite ? center.y : (real)0;
  bound->center[2] = finite ? center.z : (real)0;
  bound->extent = finite ? extent : (real)0;
  bound->box[0] = finite ? half_extents.x : (real)0;
  bound->box[1] = finite ? half_extents.y : (real)0;
  bound->box[2] = finite ? half_extents.z : (real)0;
  bound->bounding_radius = finite ? bounding_radius : (real)0;
  return finite;
}

#endif
