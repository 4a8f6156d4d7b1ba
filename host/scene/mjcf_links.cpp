#include "host/scene/mjcf_links.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/scene/json_node.hpp"

namespace lockstep {

namespace {

template <class Value>
const Value& find(const std::unordered_map<std::string, Value>& names, const XmlNode& node, const char* attribute,
                  const char* what) {
  const auto found = names.find(node.text(attribute));
  if (found != names.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [other, value] : names) known.push_back(other);
  std::sort(known.begin(), known.end());
  node.unknown(attribute, what, std::move(known));
}

RobotJoint& joint_of(const XmlNode& node, const char* attribute, const MjcfNames& names, Robot& robot,
                     double& reference) {
  const MjcfJointName& name = find(names.joints, node, attribute, "joint");
  RobotJoint& joint = robot.joints[name.joint];
  reference = name.reference;
  if (joint.kind == RobotJointKind::ball || joint.kind == RobotJointKind::floating)
    node.fail(attribute, "is a joint without an axis, which nothing here drives or locks");
  return joint;
}

// ---- actuators: their controls are 0, so that a position or velocity actuator holds its joint at 0, and a motor rests

JointSpring read_servo(const MjcfElement& element, const std::string& kind) {
  JointSpring servo;
  if (kind == "position") {
    servo.stiffness = element.not_negative("kp", 1);
    servo.damping = element.not_negative("kv", 0);
    element.expect_zero("dampratio", "is not read; give kv");
    element.expect_zero("inheritrange", "is not read");
    element.expect_zero("timeconst", "is a filter, which is not simulated; leave it out");
  } else if (kind == "velocity") {
    servo.damping = element.not_negative("kv", 1);
  } else if (kind == "damper") {
    servo.damping = 0;  // of its control, which is 0
  } else if (kind == "general" && element.text("biastype", "none") == "affine") {
    const std::vector<double> bias =
        element.has("biasprm") ? element.holder("biasprm").numbers("biasprm", 1, 10) : std::vector<double>{0};
    const auto at = [&](std::size_t i) { return i < bias.size() ? bias[i] : 0.0; };
    if (at(0) != 0 || at(1) > 0 || at(2) > 0)
      element.holder("biasprm").fail("biasprm", "must be 0 -kp -kv, of a spring and a damper");
    servo.stiffness = -at(1);
    servo.damping = -at(2);
  }
  return servo;
}

constexpr const char* actuator_kinds[] = {"motor", "position", "velocity", "damper", "general"};

// In MuJoCo a class has one default for actuators of all kinds, here one for each kind.
void expect_own_defaults(const XmlNode& node, const MjcfDefaults& defaults) {
  for (const char* kind : actuator_kinds) {
    if (node.name() == kind) continue;
    const MjcfElement other = defaults.element(node, 0, kind);
    for (const char* attribute : {"gear", "kp", "kv", "dyntype", "biastype", "biasprm"})
      if (!node.has(attribute) && other.has(attribute))
        other.holder(attribute).fail(attribute,
                                     fmt::format("is a default of actuators of all kinds, and this class has "
                                                 "a <{0}>; give it in <default> <{0}>, or there",
                                                 node.name()));
  }
}

void read_actuator(const MjcfElement& element, const MjcfNames& names, Robot& robot) {
  const XmlNode& node = element.node();
  const std::string kind = node.name();
  element.expect_attributes({"name",      "class",       "group",       "nsample",      "interp",        "delay",
                             "ctrlrange", "ctrllimited", "forcerange",  "forcelimited", "actrange",      "actlimited",
                             "gear",      "lengthrange", "cranklength", "joint",        "jointinparent", "tendon",
                             "cranksite", "slidersite",  "site",        "refsite",      "body",          "actdim",
                             "dyntype",   "gaintype",    "biastype",    "dynprm",       "gainprm",       "biasprm",
                             "actearly",  "kp",          "kv",          "dampratio",    "timeconst",     "inheritrange",
                             "damping",   "armature",    "user"});
  element.expect_zero("damping", "is not read; give it to the joint");
  for (const char* other : {"tendon", "site", "body", "jointinparent", "slidersite", "cranksite", "refsite"})
    if (node.has(other)) node.fail(other, "is nothing that is driven here; only joints are");
  if (!node.has("joint")) node.fail("needs the attribute \"joint\"");
  if (kind == "general" && element.text("dyntype", "none") != "none")
    element.holder("dyntype").fail("dyntype", "must be none: actuators have no states of their own here");
  double reference = 0;
  RobotJoint& joint = joint_of(node, "joint", names, robot, reference);
  JointSpring servo = read_servo(element, kind);
  const double gear = element.has("gear") ? element.holder("gear").numbers("gear", 1, 6)[0] : 1;
  servo.stiffness *= gear * gear;
  servo.damping *= gear * gear;
  if (servo.stiffness == 0 && servo.damping == 0) return;
  servo.rest = -reference;  // the target is 0 as the file counts
  if (!joint.servo) {
    joint.servo = servo;
    return;
  }
  joint.servo->stiffness += servo.stiffness;  // both have the same target
  joint.servo->damping += servo.damping;
}

// ---- equality

void read_joint_lock(const XmlNode& node, const MjcfNames& names, Robot& robot) {
  node.expect_attributes({"name", "class", "active", "solref", "solimp", "joint1", "joint2", "polycoef"});
  if (node.has("joint2"))
    node.fail("joint2", "joints that follow another one are not simulated; remove it, and give the joint a spring");
  double reference = 0;
  RobotJoint& joint = joint_of(node, "joint1", names, robot, reference);
  joint.locked_at = node.has("polycoef") ? node.numbers("polycoef", 1, 5)[0] : 0;
}

void read_loop(const XmlNode& node, const MjcfNames& names, Robot& robot) {
  const bool is_ball = node.name() == "connect";
  for (const char* site : {"site1", "site2"})
    if (node.has(site)) node.fail(site, "sites are not read; give body1 and body2");
  if (is_ball)
    node.expect_attributes({"name", "class", "active", "solref", "solimp", "body1", "body2", "anchor"});
  else
    node.expect_attributes(
        {"name", "class", "active", "solref", "solimp", "body1", "body2", "anchor", "relpose", "torquescale"});
  if (node.has("relpose")) {
    const std::vector<double> pose = node.numbers("relpose", 1, 7);  // a quaternion of 0 stands for that at load
    if (std::any_of(pose.begin() + std::min<std::ptrdiff_t>(3, std::ssize(pose)), pose.end(),
                    [](double x) { return x != 0; }))
      node.fail("relpose", "is not read: bodies are held as they stand at load; leave it out");
  }
  RobotLoop loop;
  loop.name = node.has("name") ? node.text("name") : fmt::format("loop_{}", robot.loops.size());
  loop.location = fmt::format("{} {}", node.location(), quote(loop.name));
  loop.is_ball = is_ball;
  loop.a = find(names.links, node, "body1", "body");
  loop.b = node.has("body2") ? find(names.links, node, "body2", "body") : 0;
  if (is_ball) loop.anchor = node.vector("anchor");
  if (loop.a == loop.b) node.fail("names one body twice; it holds two");
  robot.loops.push_back(std::move(loop));
}

}  // namespace

void read_mjcf_links(const XmlNode& top, const MjcfDefaults& defaults, const MjcfNames& names, Robot& robot) {
  for (const XmlNode& actuators : top.children("actuator")) {
    actuators.expect_children({"motor", "position", "velocity", "damper", "general"});
    for (const XmlNode& node : actuators.children()) {
      expect_own_defaults(node, defaults);
      read_actuator(defaults.element(node, 0, node.name().c_str()), names, robot);
    }
  }
  for (const XmlNode& equalities : top.children("equality")) {
    equalities.expect_children({"connect", "weld", "joint"});
    for (const XmlNode& node : equalities.children()) {
      if (!MjcfElement(node, {}).choice("active").value_or(true)) continue;
      if (node.name() == "joint")
        read_joint_lock(node, names, robot);
      else
        read_loop(node, names, robot);
    }
  }
  for (const XmlNode& contacts : top.children("contact")) {
    for (const XmlNode& node : contacts.children("pair"))
      node.fail("is not read; contype and conaffinity of geoms say who touches");
    contacts.expect_children({"exclude"});
    for (const XmlNode& node : contacts.children("exclude")) {
      node.expect_attributes({"name", "class", "body1", "body2"});
      robot.passing.push_back({find(names.links, node, "body1", "body"), find(names.links, node, "body2", "body")});
    }
  }
}

}  // namespace lockstep
