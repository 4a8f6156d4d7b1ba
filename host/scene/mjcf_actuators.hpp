// Actuators of MJCF, their controls those of a keyframe, or 0: a servo of a joint, or nothing.
#pragma once

#include "host/scene/left_out.hpp"
#include "host/scene/mjcf_keyframe.hpp"
#include "host/scene/mjcf_links.hpp"

namespace lockstep {

/// What is read of an actuator whose joint is set: of force = gain (control or activation) + bias, in MuJoCo's words.
struct MjcfActuatorLaw {
  // a constant, of the length, of the velocity; a bias of the velocity above 0 is a damping ratio
  std::array<double, 3> gain = {1, 0, 0}, bias = {0, 0, 0};
  bool has_bias = false, has_gain_slope = false, has_state = false;
  std::string unread;  // why it is none of these
};

/// `is_clamped`: controls are kept to their ranges. `compiler` is that of the model.
void read_mjcf_actuators(const XmlNode& top, const MjcfCompiler& compiler, const MjcfDefaults& defaults,
                         const MjcfNames& names, const std::string& prefix, bool is_clamped, MjcfKeyframe& keyframe,
                         LeftOut& left_out, Robot& robot);

}  // namespace lockstep
