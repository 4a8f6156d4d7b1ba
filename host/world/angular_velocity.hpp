// How fast a body has to turn to get from one orientation to another.
#pragma once

#include "host/scene/exact_math.hpp"
#include "kernels/types.h"

namespace lockstep {

/// The angular velocity, rad/s in the world frame, that takes `from` to `to` the shorter way, at a constant rate.
Vector3 angular_velocity_between(const Quaternion& from, const Quaternion& to, double duration);

}  // namespace lockstep
