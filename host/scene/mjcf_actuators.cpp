#include "host/scene/mjcf_actuators.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/scene/json_node.hpp"

namespace lockstep {

namespace {

// ---- the law: of all kinds of actuators MuJoCo makes gains and biases, and defaults of one kind hold for all

void read_three(const XmlNode& node, const char* attribute, std::array<double, 3>& values) {
  if (!node.has(attribute)) return;
  std::vector<double> given = node.numbers(attribute, 1, 32);
  given.resize(3, 0);
  std::copy(given.begin(), given.end(), values.begin());
}

std::string word_of(const XmlNode& node, const char* attribute, std::initializer_list<std::string_view> known) {
  const std::string word = node.text(attribute);
  if (std::ranges::find(known, word) == known.end())
    node.unknown(attribute, attribute, std::vector<std::string>(known.begin(), known.end()));
  return word;
}

void read_general(const XmlNode& node, MjcfActuatorLaw& law) {
  const auto is_foreign = [](const std::string& word) {
    return word == "muscle" || word == "user" || word == "dcmotor";
  };
  if (node.has("dyntype")) {
    const std::string word =
        word_of(node, "dyntype", {"none", "integrator", "filter", "filterexact", "muscle", "user", "dcmotor", "pid"});
    law.has_state = word != "none";
    if (is_foreign(word)) law.unread = "dyntype " + word;
  }
  if (node.has("gaintype")) {
    const std::string word = word_of(node, "gaintype", {"fixed", "affine", "muscle", "user", "dcmotor", "so3", "pid"});
    law.has_gain_slope = word == "affine";
    if (is_foreign(word)) law.unread = "gaintype " + word;
  }
  if (node.has("biastype")) {
    const std::string word = word_of(node, "biastype", {"none", "affine", "muscle", "user", "dcmotor", "so3", "pid"});
    law.has_bias = word == "affine";
    law.unread = word == "none" || word == "affine" ? "" : "biastype " + word;
  }
  read_three(node, "gainprm", law.gain);
  read_three(node, "biasprm", law.bias);
}

MjcfActuatorLaw law_of(const MjcfElement& element) {
  MjcfActuatorLaw law;
  for (const XmlNode& node : element.from_farthest()) {
    const std::string kind = node.name();
    const bool is_position = kind == "position" || kind == "intvelocity";
    const auto value = [&](const char* attribute, double otherwise) {
      return node.has(attribute) ? node.not_negative(attribute) : otherwise;
    };
    if (kind == "general") read_general(node, law);
    if (kind == "motor") law = {};
    if (is_position) {
      law.gain = {value("kp", law.gain[0]), 0, 0};
      law.bias[1] = -law.gain[0];
      law.bias[2] = node.has("kv") ? -value("kv", 0) : value("dampratio", law.bias[2]);
      if (node.has("kv") && value("dampratio", 0) > 0) node.fail("dampratio", "stands beside kv; give one");
      law.has_bias = true;
      law.has_gain_slope = false;
      if (kind == "intvelocity" || node.has("timeconst"))
        law.has_state = kind == "intvelocity" || value("timeconst", 0) > 0;
    }
    if (kind == "velocity") {
      const double kv = value("kv", law.gain[0]);
      law = {};
      law.gain[0] = kv;
      law.bias[2] = -kv;
      law.has_bias = true;
    }
    if (kind == "damper") {  // of its control, which is 0
      law = {};
      law.gain = {0, 0, -value("kv", 0)};
      law.has_gain_slope = true;
    }
    if (kind == "cylinder") {
      law.has_bias = law.has_state = true;
      read_three(node, "bias", law.bias);
    }
  }
  if (!law.has_bias) law.bias = {0, 0, 0};
  if (!law.has_gain_slope) law.gain[1] = law.gain[2] = 0;
  return law;
}

// ---- what a joint moves

// The mass of a joint's own coordinate, with all joints at 0: what hangs on it, about its axis, and its armature.
double mass_of_coordinate(const Robot& robot, u32 number, double armature) {
  std::vector<std::vector<MassProperties>> hanging(robot.links.size());
  std::vector<std::optional<MassProperties>> whole(robot.links.size());
  for (std::size_t i = robot.joints.size(); i-- > 0;) {
    const RobotJoint& joint = robot.joints[i];
    std::vector<MassProperties>& own = hanging[joint.child];
    if (robot.links[joint.child].inertial) own.push_back(*robot.links[joint.child].inertial);
    if (own.empty()) continue;
    whole[joint.child] = together(own);
    hanging[joint.parent].push_back(transformed(*whole[joint.child], joint.position, joint.orientation));
  }
  const RobotJoint& joint = robot.joints[number];
  const std::optional<MassProperties>& solid = whole[joint.child];
  if (!solid) return armature;
  if (joint.kind == RobotJointKind::prismatic || joint.kind == RobotJointKind::sliding) return armature + solid->mass;
  const Vector3 n = exact::unit(joint.axis), arm = exact::cross(n, exact::subtract(solid->center, joint.anchor));
  const std::array<double, 6>& k = solid->inertia;
  const Vector3 momentum = {k[0] * n[0] + k[3] * n[1] + k[4] * n[2], k[3] * n[0] + k[1] * n[1] + k[5] * n[2],
                            k[4] * n[0] + k[5] * n[1] + k[2] * n[2]};
  return armature + exact::dot(n, momentum) + solid->mass * exact::dot(arm, arm);
}

// ---- actuators

#define MJCF_ACTUATORS "general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder"

bool is_read(std::string_view kind) {
  constexpr std::string_view kinds[] = {MJCF_ACTUATORS};
  return std::ranges::find(kinds, kind) != std::end(kinds);
}

class Actuators {
 public:
  Actuators(const MjcfCompiler& compiler, const MjcfNames& names, const std::string& prefix, bool is_clamped,
            LeftOut& left_out, Robot& robot)
      : compiler_(compiler),
        names_(names),
        prefix_(prefix),
        is_clamped_(is_clamped),
        left_out_(left_out),
        robot_(robot) {}

  // `wanted` is its control, before its range bounds it.
  void read(const MjcfElement& element, double wanted) {
    RobotActuator actuator = begin(element.node());
    read_drive(element, wanted, actuator);
    robot_.actuators.push_back(std::move(actuator));
  }

  // One that drives nothing here, whatever its control.
  void add_idle(const XmlNode& node, const std::string& refusal) {
    RobotActuator actuator = begin(node);
    actuator.drive.refusal = refusal;
    robot_.actuators.push_back(std::move(actuator));
  }

 private:
  RobotActuator begin(const XmlNode& node) const {
    RobotActuator actuator;
    actuator.drive.name =
        prefix_ + (node.has("name") ? node.text("name") : fmt::format("actuator_{}", robot_.actuators.size()));
    return actuator;
  }

  void read_drive(const MjcfElement& element, double wanted, RobotActuator& actuator) {
    const XmlNode& node = element.node();
    ActuatorDescription& drive = actuator.drive;
    const MjcfActuatorLaw law = law_of(element);
    const auto idle = [&](const std::string& why) { drive.refusal = why; };
    if (!law.unread.empty()) {
      idle("has the " + law.unread + ", which is not simulated");
      return refuse(node, drive.refusal, law.unread);
    }
    const char* target = node.has("joint") ? "joint" : node.has("jointinparent") ? "jointinparent" : nullptr;
    const MjcfJointName* name = target ? &find_named(names_.joints, node, target, "joint", prefix_) : nullptr;
    if (const auto range = range_of_control(element, name)) drive.range = *range;
    drive.control = wanted;
    const double control = std::clamp(wanted, drive.range[0], drive.range[1]);
    const auto at = [&](std::size_t i) { return law.bias[i] + law.gain[i] * control; };
    const bool rests = at(0) == 0 && at(1) == 0 && at(2) == 0;
    if (law.has_state) idle("has a state that follows its control, which is not simulated");
    if (law.has_gain_slope) idle("has a gain that follows its joint, so that its control stays as it is");
    if (law.has_state && control != 0)
      return refuse(node, "has a control that is not 0 and a state that follows it, which is not simulated", "state");
    if (!has_one_axis(name)) {
      idle("drives something else than a joint with one axis, which is not simulated");
      if (rests) return left_out_.add(node.location(), node.name() + " whose control is 0");
      return refuse(node, drive.refusal, "target");
    }
    const double gear = element.has("gear") ? element.holder("gear").numbers("gear", 1, 6)[0] : 1;
    drive.joint = name->joint;
    if (gear == 0) return idle("has a gear of 0");
    if (at(1) > 0 || (at(2) > 0 && !is_ratio(law))) {
      idle("pushes a joint away from where it is to be, which is not simulated");
      return refuse(node, drive.refusal, "unstable bias");
    }
    const std::array<double, 2> forces = forces_of(element, gear, *name);
    const bool is_motor = at(1) == 0;
    if (is_motor && at(2) != 0 && forces != any_force) {
      idle("has a force range and damps, so that its control is 0");
      if (at(0) != 0) return refuse(node, "has a force range and a speed to follow, which is not simulated", "speed");
    }
    if (is_motor) {
      drive.force_at_zero = gear * law.bias[0];
      drive.force = gear * law.gain[0];
      drive.forces = forces;
    }
    if (at(1) == 0 && at(2) == 0) return;
    JointSpring servo;
    servo.stiffness = 0 - at(1) * gear * gear;
    servo.damping = 0 - at(2) * gear * gear;
    if (is_ratio(law)) {  // the damping of the actuator is 2 ratio sqrt(kp m), m the mass of its own coordinate
      const double mass = mass_of_coordinate(robot_, name->joint, name->armature) / (gear * gear);
      servo.damping = 2 * law.bias[2] * exact::square_root(-law.bias[1] * mass) * gear * gear;
    }
    servo.rest = (is_motor ? 0 : -at(0) / (at(1) * gear)) - name->reference;
    servo.forces = forces;
    if (!is_motor) {
      drive.rest_at_zero = -law.bias[0] / (at(1) * gear) - name->reference;
      drive.rest = -law.gain[0] / (at(1) * gear);
      actuator.servo = static_cast<u32>(robot_.joints[name->joint].servos.size());
    }
    robot_.joints[name->joint].servos.push_back(servo);
  }

  void refuse(const XmlNode& node, const std::string& why, const std::string& what) {
    left_out_.approximate(node.location(), why + "; remove it, or run with --approximate", node.name() + " " + what);
  }

  static bool is_ratio(const MjcfActuatorLaw& law) { return law.bias[2] > 0 && law.gain[0] == -law.bias[1]; }

  bool has_one_axis(const MjcfJointName* name) const {
    if (name == nullptr) return false;
    const RobotJointKind kind = robot_.joints[name->joint].kind;
    return kind != RobotJointKind::ball && kind != RobotJointKind::floating;
  }

  // Within which its control acts; none: anywhere.
  std::optional<std::array<double, 2>> range_of_control(const MjcfElement& element, const MjcfJointName* name) const {
    if (!is_clamped_) return std::nullopt;
    const double share = element.number("inheritrange", 0);
    if (!(share > 0) || element.has("ctrlrange") || !has_one_axis(name))
      return range_of(element, "ctrlrange", "ctrllimited");
    const RobotJoint& joint = robot_.joints[name->joint];
    const double middle = 0.5 * (joint.low + joint.high) + name->reference, half = 0.5 * (joint.high - joint.low);
    return std::array{middle - share * half, middle + share * half};
  }

  std::optional<std::array<double, 2>> range_of(const MjcfElement& element, const char* range,
                                                const char* limited) const {
    if (!element.has(range) || !element.choice(limited).value_or(compiler_.autolimits)) return std::nullopt;
    const std::vector<double> given = element.holder(range).numbers(range, 2, 2);
    if (!(given[0] <= given[1]))
      element.holder(range).fail(range, fmt::format("must not begin above its end, is {} to {}", given[0], given[1]));
    return std::array<double, 2>{given[0], given[1]};
  }

  std::array<double, 2> forces_of(const MjcfElement& element, double gear, const MjcfJointName& name) const {
    std::array<double, 2> forces = name.actuator_forces;
    if (const auto range = range_of(element, "forcerange", "forcelimited")) {
      const double a = gear * (*range)[0], b = gear * (*range)[1];
      forces = {std::max(forces[0], std::min(a, b)), std::min(forces[1], std::max(a, b))};
    }
    return forces;
  }

  const MjcfCompiler& compiler_;
  const MjcfNames& names_;
  const std::string& prefix_;
  const bool is_clamped_;
  LeftOut& left_out_;
  Robot& robot_;
};

// Of option actuatorgroupdisable.
std::vector<double> disabled_groups(const XmlNode& top) {
  std::vector<double> groups;
  for (const XmlNode& option : top.children("option"))
    if (option.has("actuatorgroupdisable")) groups = option.numbers("actuatorgroupdisable", 1, 31);
  return groups;
}

}  // namespace

void read_mjcf_actuators(const XmlNode& top, const MjcfCompiler& compiler, const MjcfDefaults& defaults,
                         const MjcfNames& names, const std::string& prefix, bool is_clamped, MjcfKeyframe& keyframe,
                         LeftOut& left_out, Robot& robot) {
  Actuators actuators(compiler, names, prefix, is_clamped, left_out, robot);
  const std::vector<double> disabled = disabled_groups(top);
  for (const XmlNode& all : top.children("actuator")) {
    for (const XmlNode& node : all.children()) {
      const MjcfElement element = defaults.element(node, 0, {MJCF_ACTUATORS});
      const double wanted = keyframe.next_control();
      if (std::ranges::find(disabled, element.number("group", 0)) != disabled.end()) {
        left_out.add(node.location(), "disabled " + node.name());
        actuators.add_idle(node, "is disabled");
      } else if (is_read(node.name())) {
        actuators.read(element, wanted);
      } else {
        actuators.add_idle(node, "is not simulated");
        if (node.name() == "adhesion" && wanted == 0)
          left_out.add(node.location(), "adhesion whose control is 0");
        else if (wanted != 0)
          left_out.approximate(node.location(),
                               "has a control that is not 0 and is not simulated; remove it, or run with --approximate",
                               node.name());
      }
    }
  }
}

#undef MJCF_ACTUATORS

}  // namespace lockstep
