#include "host/scene/actuators.hpp"

#include <algorithm>
#include <cmath>

#include "host/scene/scene.hpp"

namespace lockstep {

namespace {

// A speed that no joint reaches, m/s or rad/s: a motor that wants it gives all of its force.
constexpr double unreachable_speed = 1e6;

}  // namespace

void drive(std::span<const ActuatorDescription> actuators, u32 index, JointDescription& joint) {
  std::optional<double> rest, force;
  for (const ActuatorDescription& actuator : actuators) {
    if (actuator.joint != index || !actuator.refusal.empty()) continue;
    const double control = std::clamp(actuator.control, actuator.range[0], actuator.range[1]);
    if (actuator.rest != 0) rest = rest.value_or(actuator.rest_at_zero) + actuator.rest * control;
    if (actuator.force == 0 && actuator.force_at_zero == 0) continue;
    force = force.value_or(0) +
            std::clamp(actuator.force_at_zero + actuator.force * control, actuator.forces[0], actuator.forces[1]);
  }
  if (rest && joint.spring) joint.spring->rest = *rest;
  if (!force) return;
  joint.motor_speed = *force == 0 ? 0 : std::copysign(unreachable_speed, *force);
  joint.motor_force = std::abs(*force);
}

}  // namespace lockstep
