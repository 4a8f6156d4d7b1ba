#include "host/scene/mjcf_keyframe.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/scene/json_node.hpp"

namespace lockstep {

namespace {

constexpr std::size_t most_numbers = 1000000;

XmlNode key_called(const XmlNode& top, const std::string& name) {
  std::vector<std::string> known;
  for (const XmlNode& all : top.children("keyframe")) {
    for (const XmlNode& key : all.children("key")) {
      const std::string own = key.has("name") ? key.text("name") : std::to_string(known.size());
      if (own == name) return key;
      known.push_back(own);
    }
  }
  if (known.empty()) throw Error(Failure::input, top.source(), "has no keyframes; leave the name of one out");
  throw Error(Failure::input, top.source(), "unknown keyframe " + quote(name) + "; " + suggestion(name, known));
}

std::vector<double> numbers_of(const XmlNode& key, const char* attribute) {
  return key.has(attribute) ? key.numbers(attribute, 0, most_numbers) : std::vector<double>();
}

// As MuJoCo has it, one of length 0 rotates nothing.
Quaternion unit_of(const double* wxyz) {
  const Quaternion q = {wxyz[1], wxyz[2], wxyz[3], wxyz[0]};
  return exact::length(q) > 0 ? exact::unit(q) : Quaternion{0, 0, 0, 1};
}

// Of a floating joint, whose parent is the world: its child's frame is put there.
RobotPose from_zero(const RobotJoint& joint, const RobotPose& pose) {
  return inverse(RobotPose{joint.position, joint.orientation}) * pose;
}

}  // namespace

MjcfKeyframe::MjcfKeyframe(const XmlNode& top, LeftOut& left_out) {
  const std::string& name = left_out.reading().keyframe;
  if (name.empty()) return;
  node_ = key_called(top, name);
  positions_ = numbers_of(*node_, "qpos");
  controls_ = numbers_of(*node_, "ctrl");
  mocap_positions_ = numbers_of(*node_, "mpos");
  mocap_orientations_ = numbers_of(*node_, "mquat");
  for (const char* attribute : {"qvel", "act"}) {
    const std::vector<double> values = numbers_of(*node_, attribute);
    if (std::ranges::any_of(values, [](double x) { return x != 0; }))
      left_out.approximate(node_->location() + " " + attribute,
                           "is not 0, and keyframes give positions and controls alone; set it to 0, or run with "
                           "--approximate",
                           std::string("key ") + attribute);
  }
}

const double* MjcfKeyframe::next(const char* attribute, const std::vector<double>& values, std::size_t& at,
                                 std::size_t count) const {
  if (values.empty()) return nullptr;
  if (values.size() - at < count)
    node_->fail(attribute, fmt::format("has {} numbers, and the model wants more", values.size()));
  at += count;
  return values.data() + (at - count);
}

void MjcfKeyframe::set_start(RobotJoint& joint, double reference) {
  const bool is_floating = joint.kind == RobotJointKind::floating, is_ball = joint.kind == RobotJointKind::ball;
  const double* q = next("qpos", positions_, position_, is_floating ? 7 : is_ball ? 4 : 1);
  if (q == nullptr) return;
  if (is_floating) {
    joint.start_pose = from_zero(joint, {{q[0], q[1], q[2]}, unit_of(q + 3)});
  } else if (is_ball) {
    const Quaternion rotation = unit_of(q);
    joint.start_pose = {exact::subtract(joint.anchor, exact::rotate(rotation, joint.anchor)), rotation};
  } else {
    joint.start = q[0] - reference;
  }
}

void MjcfKeyframe::set_mocap_start(RobotJoint& joint) {
  RobotPose pose = {joint.position, joint.orientation};
  if (const double* p = next("mpos", mocap_positions_, mocap_position_, 3)) pose.position = {p[0], p[1], p[2]};
  if (const double* q = next("mquat", mocap_orientations_, mocap_orientation_, 4)) pose.orientation = unit_of(q);
  if (node_) joint.start_pose = from_zero(joint, pose);
}

double MjcfKeyframe::next_control() {
  const double* control = next("ctrl", controls_, control_, 1);
  return control != nullptr ? *control : 0;
}

void MjcfKeyframe::expect_all_read() const {
  const auto expect = [&](const char* attribute, const std::vector<double>& values, std::size_t read) {
    if (values.size() != read)
      node_->fail(attribute, fmt::format("has {} numbers, and the model wants {}", values.size(), read));
  };
  expect("qpos", positions_, position_);
  expect("ctrl", controls_, control_);
  expect("mpos", mocap_positions_, mocap_position_);
  expect("mquat", mocap_orientations_, mocap_orientation_);
}

}  // namespace lockstep
