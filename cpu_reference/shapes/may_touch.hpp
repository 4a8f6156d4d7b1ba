// Which shapes may touch within the step. kernels/shapes/may_touch.h is the twin.
#pragma once

#include "cpu_reference/grid.hpp"

namespace lockstep::reference {

/// A shape that is a trigger feels the solid shapes of dynamic bodies.
inline bool feels(const ShapeInfo& a, const ShapeInfo& b, const BodyInfo& body_b) {
  return (a.flags & SHAPE_IS_TRIGGER) == 0 || (body_b.kind == BODY_DYNAMIC && (b.flags & SHAPE_IS_TRIGGER) == 0);
}

/// Two shapes can make contacts, or a trigger can feel the other: other bodies of one world, one of them dynamic, and
/// both filters let the other through.
inline bool may_touch(const ShapeInfo& a, const ShapeInfo& b, const BodyInfo& body_a, const BodyInfo& body_b) {
  return a.body != b.body && body_a.world == body_b.world &&
         (body_a.kind == BODY_DYNAMIC || body_b.kind == BODY_DYNAMIC) && (a.category & b.mask) != 0 &&
         (b.category & a.mask) != 0 && feels(a, b, body_b) && feels(b, a, body_a);
}

/// The gap of two shapes that come closer at `speed` is open to at most the margin at the end of the step.
template <class real>
bool within_range(const StepParams<real>& params, real margin, real gap, real speed) {
  return gap <= margin + step_length(params) * speed;
}

/// Speed at which two bodies approach each other along the normal from b to a, at a point that is at these arms from
/// their centres of mass; 0 where they part.
template <class real>
real approach_speed(Vec3<real> normal, const Motion<real>& motion_a, Vec3<real> arm_a, const Motion<real>& motion_b,
                    Vec3<real> arm_b) {
  const real speed = dot3(normal, sub3(point_velocity(motion_b, arm_b), point_velocity(motion_a, arm_a)));
  return speed > 0 ? speed : real(0);
}

}  // namespace lockstep::reference
