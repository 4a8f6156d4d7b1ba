// The robots of a scene file, and scenes that are a robot alone.
#pragma once

#include "host/scene/read_bodies.hpp"
#include "host/scene/robot.hpp"
#include "host/scene/robot_reading.hpp"

namespace lockstep {

/// Reads the array "robots": bodies and joints are added to those of the scene.
void read_robots(const JsonNode& array, Names& names, const RobotReading& reading, Scene& scene);

/// A scene of the robot of a URDF or MJCF text, as it stands in its file, with all defaults.
Scene robot_scene(const std::string& text, const std::string& source, const RobotReading& reading);

/// Refuses bodies that are to pass through each other in a scene without a joint: the list of them is one of joints.
void expect_joints_of_passing(const Scene& scene);

/// Whether a file of this name is a robot's.
bool is_robot(const std::string& path);

}  // namespace lockstep
