// Robots and scenes from MJCF files (mujoco.readthedocs.io, "XML Reference"); docs/reference/formats.md says what is
// read and what is not.
#pragma once

#include <string>

#include "host/scene/left_out.hpp"
#include "host/scene/robot_model.hpp"

namespace lockstep {

/// The link "world" is the root, and does not move. Throws Error (input): one line with the file, its line, what is
/// wrong and the cure. Meshes are looked for from the folder of `source`.
/// `Robot::notes` say what was left out.
Robot parse_mjcf(const std::string& text, const std::string& source, const RobotReading& reading = {});

/// Whether a file of this name is read as MJCF.
bool is_mjcf(const std::string& path);

}  // namespace lockstep
