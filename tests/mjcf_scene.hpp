// Scenes of an MJCF text, for tests; its robot is called r.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>

#include "host/scene/read.hpp"

namespace lockstep::mjcf_scene {

inline Scene mjcf(const std::string& inside) {
  return parse_scene("<mujoco model=\"r\">" + inside + "</mujoco>", "robot.xml");
}

inline Scene world(const std::string& bodies, const std::string& more = "") {
  return mjcf("<compiler angle=\"radian\"/>" + more + "<worldbody>" + bodies + "</worldbody>");
}

inline const BodyDescription& body(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.bodies, "r/" + name, &BodyDescription::name);
  if (found == scene.bodies.end()) throw std::runtime_error("no body " + name);
  return *found;
}

}  // namespace lockstep::mjcf_scene
