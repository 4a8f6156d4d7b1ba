// How fast a body has to turn to get from one orientation to another.
#pragma once

#include "host/scene/exact_math.hpp"
#include "kernels/types.h"

namespace lockstep {

/// The angular velocity, rad/s in the world frame, that takes `from` to `to` the shorter way in so many sub-steps of
/// `dt`, as integrate_positions turns bodies: q' = |q + dt/2 (w, 0) q| is a rotation by 2 atan(dt |w| / 2) about w.
Vector3 angular_velocity_between(const Quaternion& from, const Quaternion& to, double dt, u32 substeps);

}  // namespace lockstep
