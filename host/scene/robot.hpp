// A robot as bodies and joints: links that are fixed to each other become one body.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/scene/robot_model.hpp"

namespace lockstep {

/// What a scene adds to a joint of a robot.
struct RobotDrive {
  std::optional<double> start = {};         // rad or m: where it stands at load; none: as the robot says
  double motor_speed = 0, motor_force = 0;  // as of JointDescription
  std::optional<JointSpring> spring = {};
};

/// How a scene uses a robot.
struct RobotUse {
  std::string name;              // bodies and joints are called NAME/LINK and NAME/JOINT
  Vector3 position = {0, 0, 0};  // of the frame of the root link
  Quaternion orientation = {0, 0, 0, 1};
  bool fixed = false;  // the root link does not move; one that is called "world" never does
  // of all shapes; of those of a robot that says it itself only where they are given
  std::optional<u32> material, category, mask;
  u32 first_material = 0;           // of those that the robot brings
  std::vector<u32> classes = {1u};  // the bits that its classes of shapes have here
  std::vector<RobotDrive> drives;   // one for each joint of the robot
};

/// Joints name bodies, and actuators and couplings joints, by their place among these.
struct RobotComponents {
  std::vector<BodyDescription> bodies;
  std::vector<JointDescription> joints;
  std::vector<ActuatorDescription> actuators;
  std::vector<CouplingDescription> couplings;
  std::vector<std::array<u32, 2>> passing;
};

/// Throws Error (input) where a body that moves has no mass.
RobotComponents make_robot(const Robot& robot, const RobotUse& use);

/// What of an engine's joint a joint of a robot is; nothing for those that are fixed or floating.
std::optional<JointKind> kind_of(RobotJointKind kind);

}  // namespace lockstep
