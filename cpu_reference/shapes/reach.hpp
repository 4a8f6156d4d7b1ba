// Which shapes may touch within the step. kernels/shapes/reach.h is the twin.
#pragma once

#include "cpu_reference/grid.hpp"

namespace lockstep::reference {

/// Two shapes can make contacts: other bodies of one world, one of them dynamic, and both filters let the other
/// through.
inline bool may_touch(const ShapeInfo& a, const ShapeInfo& b, const BodyInfo& body_a, const BodyInfo& body_b) {
  return a.body != b.body && body_a.world == body_b.world &&
         (body_a.kind == BODY_DYNAMIC || body_b.kind == BODY_DYNAMIC) && (a.category & b.mask) != 0 &&
         (b.category & a.mask) != 0;
}

/// The gap of two shapes that come closer at `speed` is open to at most the margin at the end of the step.
template <class real>
bool within_reach(const StepParams<real>& params, real gap, real speed) {
  return gap <= params.margin + step_length(params) * speed;
}

/// Speed at which the bodies approach each other at the point of touch; 0 where they part.
template <class real>
real approach_speed(const Touch<real>& touch, const Motion<real>& motion_a, Vec3<real> position_a,
                    const Motion<real>& motion_b, Vec3<real> position_b) {
  const Vec3<real> velocity_a = point_velocity(motion_a, sub3(touch.point, position_a));
  const Vec3<real> velocity_b = point_velocity(motion_b, sub3(touch.point, position_b));
  const real speed = dot3(touch.normal, sub3(velocity_b, velocity_a));
  return speed > 0 ? speed : real(0);
}

}  // namespace lockstep::reference
