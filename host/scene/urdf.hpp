// Robots as URDF files describe them (wiki.ros.org/urdf/XML): links, each in a frame of its own, and joints that make a
// tree of them. docs/formats.md says what is read and what is not.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/scene/mass_properties.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// All in the frame of the link.
struct RobotLink {
  std::string name, place;                 // the place is for messages
  std::optional<MassProperties> inertial;  // none: it has no mass of its own
  std::vector<ShapeDescription> shapes;    // without materials and filters
};

enum class RobotJointKind { fixed, revolute, continuous, prismatic, planar, floating };

struct RobotJoint {
  std::string name, place;
  RobotJointKind kind = RobotJointKind::fixed;
  u32 parent = 0, child = 0;     // links
  Vector3 position = {0, 0, 0};  // of the child's frame in the parent's, where the joint is at 0
  Quaternion orientation = {0, 0, 0, 1};
  Vector3 axis = {1, 0, 0};          // in the child's frame; need not be unit
  double low = 0, high = 0;          // rad or m; of revolute and prismatic ones
  double damping = 0, friction = 0;  // N m s/rad and N m, or N s/m and N
};

struct Robot {
  std::string name;
  std::vector<RobotLink> links;
  std::vector<RobotJoint> joints;  // a parent before its children
  u32 root = 0;                    // the link that is no child
};

/// Throws Error (input): one line with the file, its line, what is wrong and the cure. Meshes are looked for from the
/// folder of `source`.
Robot parse_urdf(const std::string& text, const std::string& source);

/// Whether a file of this name is read as URDF.
bool is_urdf(const std::string& path);

}  // namespace lockstep
