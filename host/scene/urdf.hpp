// Robots from URDF files (wiki.ros.org/urdf/XML); docs/reference/formats.md says what is read and what is not.
#pragma once

#include <string>

#include "host/scene/robot_model.hpp"
#include "host/scene/robot_reading.hpp"

namespace lockstep {

/// Throws Error (input): one line with the file, its line, what is wrong and the cure. Meshes are looked for from the
/// folder of `source`, and in the packages of `reading`. What is left out or mended is among the robot's notes.
Robot parse_urdf(const std::string& text, const std::string& source, const RobotReading& reading);

/// Whether a file of this name is read as URDF.
bool is_urdf(const std::string& path);

}  // namespace lockstep
