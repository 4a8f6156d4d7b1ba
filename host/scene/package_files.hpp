// Where the files are that robots name: package://NAME/rest, file://path, or a path from the robot's file.
#pragma once

#include <map>
#include <string>

#include "host/scene/xml_node.hpp"

namespace lockstep {

/// The path of the file that an attribute names. package://NAME/rest is looked for in packages.at(NAME), below the
/// nearest folder above the robot's file that holds NAME/rest, and in the folders of ROS_PACKAGE_PATH. Upper and lower
/// case of its last part may differ from the file's. Throws Error (input) where there is none.
std::string robot_file_path(const XmlNode& node, const char* attribute,
                            const std::map<std::string, std::string>& packages);

}  // namespace lockstep
