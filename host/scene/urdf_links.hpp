// The links of URDF files: masses, and shapes with their meshes.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "host/scene/left_out.hpp"
#include "host/scene/robot_model.hpp"
#include "host/scene/robot_reading.hpp"
#include "host/scene/xml_node.hpp"

namespace lockstep {

/// What the elements of a file share while it is read.
struct UrdfReading {
  const RobotReading& robots;
  LeftOut left_out;
  std::vector<std::string> mended;  // links whose inertia no body has

  /// Counts the attributes and elements of a node that are none of these. Refuses xacro that was not expanded.
  void leave_out_others(const XmlNode& node, std::initializer_list<std::string_view> attributes,
                        std::initializer_list<std::string_view> children = {});
};

/// The element <origin> of a node, where it has one.
void read_urdf_origin(const XmlNode& node, UrdfReading& reading, Vector3& position, Quaternion& orientation);

RobotLink read_urdf_link(const XmlNode& node, UrdfReading& reading);

}  // namespace lockstep
