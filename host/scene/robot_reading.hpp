// How robot files are read, whatever their format.
#pragma once

#include <map>
#include <string>

#include "host/scene/read.hpp"

namespace lockstep {

struct RobotReading {
  bool strict = false;                          // what would be left out is refused
  std::map<std::string, std::string> packages;  // folders of package://NAME, before all others
};

/// As those of host/scene/read.hpp, whose robots are read with all defaults.
Scene read_scene(const std::string& path_or_name, u32 seed, const RobotReading& reading);
Scene parse_scene(const std::string& text, const std::string& source, u32 seed, const RobotReading& reading);

}  // namespace lockstep
