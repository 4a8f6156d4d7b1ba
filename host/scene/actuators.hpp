// What drives joints by controls: servos, whose springs rest where the control says, and motors, whose force it is.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "kernels/types.h"

namespace lockstep {

struct JointDescription;

struct ActuatorDescription {
  std::string name = {};  // may be empty
  u32 joint = NONE;       // index into Scene::joints
  double control = 0;     // in units of its own: often rad, m or N m
  std::array<double, 2> range = {-std::numeric_limits<double>::infinity(),
                                 std::numeric_limits<double>::infinity()};  // within which the control acts
  // of a servo: what its joint's spring rests at with the controls of all its servos 0, rad or m, and for a unit of
  // this control so much more
  double rest_at_zero = 0, rest = 0;
  // of a motor: its force with a control of 0, N or N m, for a unit of it so much more, and its bounds
  double force_at_zero = 0, force = 0;
  std::array<double, 2> forces = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::string refusal = {};  // why its control cannot be another; empty: it can
};

/// Sets the spring and the motor of a joint of the scene, as its actuators drive it.
void drive(std::span<const ActuatorDescription> actuators, u32 index, JointDescription& joint);

}  // namespace lockstep
