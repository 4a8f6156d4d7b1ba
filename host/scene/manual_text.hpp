// What the manual and the schema of scenes take from the tables of settings, solvers, shapes and joints.
#pragma once

#include <string>

namespace lockstep {

/// Tables of docs/reference/scene_format.md.
std::string settings_manual();
std::string solvers_manual();
std::string oracles_manual();
std::string shapes_manual();
std::string joints_manual();

/// Lines of scenes/scene.schema.json: the settings, and the key `type` of a shape and of a joint.
std::string settings_schema();
std::string shape_types_schema();
std::string joint_types_schema();

}  // namespace lockstep
