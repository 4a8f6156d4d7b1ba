// A keyframe of an MJCF file: where its joints stand and what its actuators want at load.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/scene/left_out.hpp"
#include "host/scene/robot_model.hpp"
#include "host/scene/xml_node.hpp"

namespace lockstep {

class MjcfKeyframe {
 public:
  /// The one that the reading names; without a name all joints stand where the bodies of the file do. Refuses a name
  /// that there is not.
  MjcfKeyframe(const XmlNode& top, LeftOut& left_out);

  /// Where the next joint of the file starts: joints are asked for in the file's order, once each. `reference` is what
  /// its coordinate is in the file where it is 0 in the robot.
  void set_start(RobotJoint& joint, double reference);
  /// The same of the next mocap body, which stands on a floating joint.
  void set_mocap_start(RobotJoint& joint);
  /// The control of the next actuator of the file, before its range bounds it; 0 where the keyframe has none.
  double next_control();
  /// Refuses a keyframe that has more than was asked for.
  void expect_all_read() const;

 private:
  const double* next(const char* attribute, const std::vector<double>& values, std::size_t& at,
                     std::size_t count) const;

  std::optional<XmlNode> node_;  // none: there is no keyframe
  std::vector<double> positions_, controls_, mocap_positions_, mocap_orientations_;
  std::size_t position_ = 0, control_ = 0, mocap_position_ = 0, mocap_orientation_ = 0;  // the next ones
};

}  // namespace lockstep
