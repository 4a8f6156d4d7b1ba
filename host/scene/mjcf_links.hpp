// What in an MJCF file refers to bodies and joints by name: actuators, equality constraints, and who passes through
// whom.
#pragma once

#include <string>
#include <unordered_map>

#include "host/scene/mjcf_element.hpp"
#include "host/scene/robot_model.hpp"

namespace lockstep {

struct MjcfJointName {
  u32 joint;         // of the robot
  double reference;  // its coordinate in the file where it is 0 in the robot
};

struct MjcfNames {
  std::unordered_map<std::string, u32> links;
  std::unordered_map<std::string, MjcfJointName> joints;
};

/// Adds to the joints and loops of the robot what the elements <actuator>, <equality> and <contact> say.
void read_mjcf_links(const XmlNode& top, const MjcfDefaults& defaults, const MjcfNames& names, Robot& robot);

}  // namespace lockstep
