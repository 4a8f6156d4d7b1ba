// The joints of an MJCF body. Several in one body turn and slide one after the other.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "host/scene/left_out.hpp"
#include "host/scene/mjcf_element.hpp"
#include "host/scene/robot_model.hpp"

namespace lockstep {

/// A joint whose links and place are not known yet, and how its coordinate is counted in the file.
struct MjcfJoint {
  RobotJoint joint;
  double reference = 0;                               // the coordinate at load
  std::array<double, 2> actuator_forces = any_force;  // of all its actuators together
};

/// `number`: of the joints that the file had before it, for one without a name.
MjcfJoint read_mjcf_joint(const MjcfElement& element, const MjcfCompiler& compiler, std::size_t number,
                          LeftOut& left_out);

/// Joints that one of the engine does the work of, with all that they have: two slides and a hinge, all at right
/// angles, are a planar joint, two hinges a universal one. Else, or where one that would be lost is `used` by its name,
/// as they are.
std::vector<MjcfJoint> combined(std::vector<MjcfJoint> joints, const std::set<std::string>& used);

}  // namespace lockstep
