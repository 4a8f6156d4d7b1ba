// Which shapes may touch within the step. cpu_reference/shapes/may_touch.hpp is the twin.
#ifndef LOCKSTEP_MAY_TOUCH_H
#define LOCKSTEP_MAY_TOUCH_H

#include "grid.h"

// What no shape of the scene is, is compiled out: the test is a constant.
#if FEATURE_TRIGGERS
#define IS_TRIGGER(info) (((info).flags & SHAPE_IS_TRIGGER) != 0u)
#else
#define IS_TRIGGER(info) false
#endif

// A shape that is a trigger feels the solid shapes of dynamic bodies.
static inline bool feels(ShapeInfo a, ShapeInfo b, BodyInfo body_b) {
#if FEATURE_TRIGGERS
  return !IS_TRIGGER(a) || (body_b.kind == BODY_DYNAMIC && !IS_TRIGGER(b));
#else
  return true;
#endif
}

// Two shapes can make contacts, or a trigger can feel the other: other bodies of one world, one of them dynamic, and
// both filters let the other through.
static inline bool may_touch(ShapeInfo a, ShapeInfo b, BodyInfo body_a, BodyInfo body_b) {
  return a.body != b.body && body_a.world == body_b.world &&
         (body_a.kind == BODY_DYNAMIC || body_b.kind == BODY_DYNAMIC) && (a.category & b.mask) != 0u &&
         (b.category & a.mask) != 0u && feels(a, b, body_b) && feels(b, a, body_a);
}

// The gap of two shapes that come closer at `speed` is open to at most the margin at the end of the step.
static inline bool within_range(const StepParams* params, real margin, real gap, real speed) {
  return gap <= margin + step_length(params) * speed;
}

// Speed at which two bodies approach each other along the normal from b to a, at a point that is at these arms from
// their centres of mass; 0 where they part.
static inline real approach_speed(Vec3 normal, global const Motion* motion_a, Vec3 arm_a, global const Motion* motion_b,
                                  Vec3 arm_b) {
  const real speed = dot3(normal, sub3(point_velocity(motion_b, arm_b), point_velocity(motion_a, arm_a)));
  return speed > (real)0 ? speed : (real)0;
}

#endif
