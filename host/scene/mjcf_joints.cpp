#include "host/scene/mjcf_joints.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/scene/json_node.hpp"

namespace lockstep {

namespace {

void read_range(const MjcfElement& element, const MjcfCompiler& compiler, bool is_revolute, MjcfJoint& out) {
  const bool has_range = element.has("range");
  const std::optional<bool> said = element.choice("limited");
  if (!said.value_or(compiler.autolimits && has_range)) return;
  const XmlNode& holder = element.holder("range");
  const std::vector<double> range = holder.numbers("range", 2, 2);
  const double unit = is_revolute && compiler.degrees ? exact::pi / 180 : 1;
  RobotJoint& joint = out.joint;
  joint.low = range[0] * unit - out.reference;
  joint.high = range[1] * unit - out.reference;
  if (joint.low > joint.high)
    holder.fail("range", fmt::format("must not begin above its end, is {} to {}", range[0], range[1]));
  joint.kind = is_revolute ? RobotJointKind::revolute : RobotJointKind::prismatic;
}

// Of joints without one axis.
void expect_nothing_that_acts(const MjcfElement& element, LeftOut& left_out, const char* type) {
  for (const char* attribute : {"stiffness", "damping", "frictionloss", "armature"})
    if (element.not_negative(attribute, 0) > 0)
      left_out.approximate(element.holder(attribute).location() + " " + attribute,
                           "belongs to a joint with one axis, and this one has none; set it to 0 here, or run with "
                           "--approximate",
                           fmt::format("joint {} of a {}", attribute, type));
}

// Only its axis, its place and, where it is to be part of another one, nothing that acts.
bool is_plain(const MjcfJoint& in, RobotJointKind kind, const std::set<std::string>& used) {
  const RobotJoint& joint = in.joint;
  return joint.kind == kind && !used.contains(joint.name) && joint.damping == 0 && joint.friction == 0 &&
         joint.armature == 0 && !joint.spring;
}

// By all of them, one after the other; nothing where all are at 0.
std::optional<RobotPose> started(const std::vector<MjcfJoint>& joints) {
  RobotPose pose;
  bool is_moved = false;
  for (const MjcfJoint& in : joints) {
    pose = pose * moved(in.joint, in.joint.start);
    is_moved = is_moved || in.joint.start != 0;
  }
  return is_moved ? std::optional(pose) : std::nullopt;
}

}  // namespace

MjcfJoint read_mjcf_joint(const MjcfElement& element, const MjcfCompiler& compiler, std::size_t number,
                          LeftOut& left_out) {
  const XmlNode& node = element.node();
  MjcfJoint out;
  RobotJoint& joint = out.joint;
  joint.name = node.has("name") ? node.text("name") : fmt::format("joint_{}", number);
  joint.location = fmt::format("{} {}", node.location(), quote(joint.name));
  const std::string type = element.text("type", "hinge");
  if (type != "hinge" && type != "slide" && type != "ball" && type != "free")
    element.holder("type").unknown("type", "joint", {"hinge", "slide", "ball", "free"});
  if (type == "free") {
    joint.kind = RobotJointKind::floating;
    expect_nothing_that_acts(element, left_out, "free");
    return out;
  }
  joint.anchor = element.vector("pos", {0, 0, 0});
  if (type == "ball") {
    joint.kind = RobotJointKind::ball;
    expect_nothing_that_acts(element, left_out, "ball");
    if (element.choice("limited").value_or(compiler.autolimits && element.has("range")))
      left_out.approximate(node.location(),
                           "is a ball with limits, which are not simulated; give limited=\"false\", hinges in its "
                           "place, or run with --approximate",
                           "joint range of a ball");
    return out;
  }
  const bool is_revolute = type == "hinge";
  joint.kind = is_revolute ? RobotJointKind::continuous : RobotJointKind::sliding;
  joint.axis = element.vector("axis", {0, 0, 1});
  if (joint.axis == Vector3{0, 0, 0}) element.holder("axis").fail("axis", "must not be zero: it is a direction");
  const auto coordinate = [&](const char* attribute) {
    return is_revolute ? element.radians(attribute, 0, compiler) : element.number(attribute, 0);
  };
  out.reference = coordinate("ref");
  if (element.has("actuatorfrcrange") && element.choice("actuatorfrclimited").value_or(compiler.autolimits)) {
    const std::vector<double> range = element.holder("actuatorfrcrange").numbers("actuatorfrcrange", 2, 2);
    out.actuator_forces = {range[0], range[1]};
  }
  read_range(element, compiler, is_revolute, out);
  joint.damping = element.not_negative("damping", 0);
  joint.friction = element.not_negative("frictionloss", 0);
  joint.armature = element.not_negative("armature", 0);
  const double stiffness = element.not_negative("stiffness", 0);
  if (stiffness > 0) joint.spring = JointSpring{stiffness, 0, coordinate("springref") - out.reference};
  return out;
}

std::vector<MjcfJoint> combined(std::vector<MjcfJoint> joints, const std::set<std::string>& used) {
  const auto across = [&](std::size_t a, std::size_t b) {
    return exact::perpendicular(joints[a].joint.axis, joints[b].joint.axis);
  };
  const bool all_across = joints.size() == 3 && across(0, 1) && across(0, 2) && across(1, 2);
  if (all_across && is_plain(joints[0], RobotJointKind::sliding, used) &&
      is_plain(joints[1], RobotJointKind::sliding, used) && joints[2].joint.kind == RobotJointKind::continuous) {
    joints[2].joint.start_pose = started(joints);
    joints[2].joint.kind = RobotJointKind::planar;
    return {joints[2]};
  }
  if (joints.size() == 2 && across(0, 1) && joints[0].joint.kind == RobotJointKind::continuous &&
      is_plain(joints[1], RobotJointKind::continuous, used) && joints[0].joint.anchor == joints[1].joint.anchor) {
    joints[0].joint.start_pose = started(joints);
    joints[0].joint.kind = RobotJointKind::universal;
    joints[0].joint.second_axis = joints[1].joint.axis;
    return {joints[0]};
  }
  return joints;
}

}  // namespace lockstep
