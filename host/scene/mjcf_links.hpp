// What in an MJCF file refers to bodies, joints and sites by name: equality constraints, tendons, and who passes
// through whom; and the names themselves.
#pragma once

#include <algorithm>
#include <string>
#include <unordered_map>

#include "host/scene/left_out.hpp"
#include "host/scene/mjcf_element.hpp"
#include "host/scene/robot_model.hpp"

namespace lockstep {

struct MjcfJointName {
  u32 joint;         // of the robot
  double reference;  // its coordinate in the file where it is 0 in the robot
  double armature;
  std::array<double, 2> actuator_forces;
};

struct MjcfSite {
  u32 link;
  RobotPose pose;  // in the frame of the link
};

struct MjcfNames {
  std::unordered_map<std::string, u32> links;
  std::unordered_map<std::string, MjcfJointName> joints;
  std::unordered_map<std::string, MjcfSite> sites;
};

/// What an element finds by an attribute; `prefix` is before the names of its model. Refuses a name that there is not.
template <class Value>
const Value& find_named(const std::unordered_map<std::string, Value>& names, const XmlNode& node, const char* attribute,
                        const char* what, const std::string& prefix) {
  const auto found = names.find(prefix + node.text(attribute));
  if (found != names.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [other, value] : names)
    if (other.starts_with(prefix)) known.push_back(other.substr(prefix.size()));
  std::sort(known.begin(), known.end());
  node.unknown(attribute, what, std::move(known));
}

/// Adds to the joints and loops of the robot what the elements <equality>, <tendon> and <contact> say.
void read_mjcf_links(const XmlNode& top, const MjcfDefaults& defaults, const MjcfNames& names,
                     const std::string& prefix, LeftOut& left_out, Robot& robot);

}  // namespace lockstep
