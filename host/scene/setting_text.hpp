// What the manual and the schema of scenes say of settings and solvers, written from their tables.
#pragma once

#include <string>

namespace lockstep {

/// The tables of docs/scene_format.md: key, type and unit, initial value, meaning; and of solvers.
std::string settings_manual();
std::string solvers_manual();

/// The entries of /$defs/settings/properties of scenes/scene.schema.json, a line each.
std::string settings_schema();

}  // namespace lockstep
