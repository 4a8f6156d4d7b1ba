// What drives joints while a world runs: motors, springs that rest elsewhere, controls of actuators.
#include <fmt/format.h>

#include "host/scene/json_node.hpp"
#include "host/world/impl.hpp"

namespace lockstep {

namespace {

std::string called(const ActuatorDescription& actuator, u32 number) {
  return actuator.name.empty() ? fmt::format("actuator {}", number) : "actuator " + quote(actuator.name);
}

}  // namespace

void World::Impl::drive(u32 index, JointDescription driven) {
  validate(driven, scene);
  scene.joints[index] = std::move(driven);
  drives_set = drives_were_set = true;
}

void World::Impl::remove_from_actuators(u32 joint) {
  for (ActuatorDescription& actuator : scene.actuators) {
    if (actuator.joint == joint) actuator.joint = NONE, actuator.refusal = "has lost its joint, which was removed";
    if (actuator.joint != NONE && actuator.joint > joint) --actuator.joint;
  }
}

void World::set_motor(JointHandle joint, double speed, double force) {
  const u32 index = impl_->joints.index(joint);
  JointDescription driven = impl_->scene.joints[index];
  driven.motor_speed = speed;
  driven.motor_force = force;
  impl_->drive(index, std::move(driven));
}

void World::set_rest(JointHandle joint, double rest) {
  const u32 index = impl_->joints.index(joint);
  JointDescription driven = impl_->scene.joints[index];
  if (!driven.spring) throw Error(Failure::input, impl_->called(joint), "has no spring; change() gives it one");
  driven.spring->rest = rest;
  impl_->drive(index, std::move(driven));
}

std::span<const ActuatorDescription> World::actuators() const { return impl_->scene.actuators; }

u32 World::actuator(const std::string& name) const {
  std::vector<std::string> names;
  for (const ActuatorDescription& actuator : actuators()) names.push_back(actuator.name);
  const auto found = std::ranges::find(names, name);
  if (found == names.end())
    throw Error(Failure::input, "world", "unknown actuator " + quote(name) + "; " + suggestion(name, names));
  return static_cast<u32>(found - names.begin());
}

void World::set_control(u32 actuator, double control) {
  Impl& p = *impl_;
  if (actuator >= p.scene.actuators.size())
    throw Error(Failure::input, "world",
                fmt::format("has no actuator {}; it has {}", actuator, p.scene.actuators.size()));
  ActuatorDescription& driving = p.scene.actuators[actuator];
  const std::string where = called(driving, actuator);
  if (control == driving.control) return;
  if (!driving.refusal.empty()) throw Error(Failure::input, where, driving.refusal);
  expect_fits(p.scene.settings, control, where);
  JointDescription driven = p.scene.joints[driving.joint];
  if (driving.rest != 0 ? !driven.spring : driven.friction > 0)
    throw Error(Failure::input, where, "has a joint that was changed, and drives it no more");
  const double before = std::exchange(driving.control, control);
  try {
    lockstep::drive(p.scene.actuators, driving.joint, driven);
    p.drive(driving.joint, std::move(driven));
  } catch (...) {
    driving.control = before;
    throw;
  }
}

}  // namespace lockstep
