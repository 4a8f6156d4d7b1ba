// What drives joints by controls.
#pragma once

#include <span>

#include "include/lockstep/scene.hpp"

namespace lockstep {

/// Sets the spring and the motor of a joint of the scene, as its actuators drive it.
void drive(std::span<const ActuatorDescription> actuators, u32 index, JointDescription& joint);

}  // namespace lockstep
