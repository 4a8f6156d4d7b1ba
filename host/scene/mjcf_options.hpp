// What an MJCF file says of the whole: <compiler> and <option>.
#pragma once

#include "host/scene/mjcf_element.hpp"
#include "host/scene/robot_model.hpp"

namespace lockstep {

MjcfCompiler read_mjcf_compiler(const XmlNode& top);

/// The flags that switch off what moves bodies.
struct MjcfFlags {
  bool contact = true, constraint = true, equality = true, limit = true, frictionloss = true;
  bool spring = true, damper = true, actuation = true, clampctrl = true, filterparent = true;
};

/// Sets the robot's time step and gravity.
MjcfFlags read_mjcf_option(const XmlNode& top, Robot& robot);

/// Takes from a robot what the flags switch off, but for actuators.
void switch_off(const MjcfFlags& flags, Robot& robot);

}  // namespace lockstep
