// Robots of a few lines, and scenes that they are in.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "host/scene/read.hpp"
#include "tests/refusal.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep {

/// A scene of a robot in "robot.urdf", called r, and what is said of it there.
class Robots : public testing::Test {
 protected:
  Scene scene_of(const std::string& robot, const std::string& use = "", const std::string& more = "") const {
    std::ofstream(folder_.file("robot.urdf")) << robot;
    return parse_scene(R"({"robots": [{"file": "robot.urdf", "name": "r")" + use + "}]" + more + "}",
                       folder_.file("scene.json"));
  }

  // The line that a robot is refused with, the folder left out; "accepted" where it is not.
  std::string refusal(const std::string& robot, const std::string& use = "") const {
    std::string line = lockstep::refusal([&] { scene_of(robot, use); });
    for (std::size_t at; (at = line.find(folder_.file(""))) != std::string::npos;)
      line.erase(at, folder_.file("").size());
    return line;
  }

  const TemporaryFolder folder_;
};

inline std::string robot(const std::string& inside) { return "<robot name=\"x\">\n" + inside + "\n</robot>\n"; }

inline const std::string unit_inertial = R"(<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>)";

inline std::string link(const std::string& name, const std::string& inside = unit_inertial) {
  return "<link name=\"" + name + "\">" + inside + "</link>\n";
}

inline std::string joint(const std::string& type, const std::string& parent, const std::string& child,
                         const std::string& inside = "") {
  return "<joint name=\"" + parent + "_" + child + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + inside + "</joint>\n";
}

}  // namespace lockstep
