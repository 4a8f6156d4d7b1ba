// How robot files are read, whatever their format.
#pragma once

#include <map>
#include <string>

namespace lockstep {

struct RobotReading {
  bool strict = false;                               // refuses what would be left out
  bool approximate = false;                          // leaves out, or replaces, what changes the motion, too
  std::map<std::string, std::string> packages = {};  // folders of package://NAME, before all others
  std::string keyframe = {};                         // by name, or by number where it has none; empty: none
};

}  // namespace lockstep
