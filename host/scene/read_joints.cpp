#include "host/scene/read_joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "host/scene/joint_kinds.hpp"

namespace lockstep {

namespace {

constexpr const char* world_name = "world";
constexpr double degree = exact::pi / 180;

void refuse_keys(const JsonNode& node, const char* kind, std::initializer_list<const char*> keys) {
  for (const char* key : keys) {
    if (node.has(key)) node.at(key).fail(fmt::format("does not belong to a {} joint; remove it", kind));
  }
}

void need_keys(const JsonNode& node, const char* kind, std::initializer_list<const char*> keys) {
  for (const char* key : keys) {
    if (!node.has(key)) node.fail(fmt::format("a {} joint needs the key {}", kind, quote(key)));
  }
}

void read_limits(const JsonNode& node, JointFree free, JointDescription& joint) {
  if (node.has("limits") && node.has("limits_deg")) node.fail("has both \"limits\" and \"limits_deg\"; give one");
  const char* key = node.has("limits_deg") ? "limits_deg" : "limits";
  if (!node.has(key)) return;
  const JsonNode limits = node.at(key);
  const std::vector<JsonNode> pair = limits.elements();
  if (pair.size() != 2) limits.must_be("an array of 2 numbers, the low and the high limit");
  joint.limited = true;
  joint.low = pair[0].number();
  joint.high = pair[1].number();
  if (joint.low > joint.high) limits.fail("the low limit must not be above the high one");
  if (free == FREE_LENGTH && joint.low < 0) limits.fail("a distance is never below 0");
  if (free != FREE_ANGLE) return;
  const double scale = node.has("limits_deg") ? degree : 1;
  joint.low *= scale;
  joint.high *= scale;
}

void read_motor(const JsonNode& node, JointFree free, JointDescription& joint) {
  if (!node.has("motor")) return;
  const JsonNode motor = node.at("motor");
  const bool is_angular = free == FREE_ANGLE;
  if (is_angular) {
    motor.expect_object({"speed", "speed_deg", "max_torque"});
    joint.motor_speed = angle_at(motor, "speed", "speed_deg");
  } else {
    motor.expect_object({"speed", "max_force"});
    joint.motor_speed = motor.at("speed").number();
  }
  joint.motor_force = motor.at(is_angular ? "max_torque" : "max_force").positive();
}

void read_friction(const JsonNode& node, JointFree free, JointDescription& joint) {
  if (!node.has("friction")) return;
  joint.friction = node.at("friction").not_negative();
  if (node.has("motor"))
    node.at("friction")
        .fail(fmt::format("does not go with a motor; take it off the motor's {}, or give it to a joint of its own",
                          free == FREE_ANGLE ? "\"max_torque\"" : "\"max_force\""));
}

void read_spring(const JsonNode& node, JointFree free, JointDescription& joint) {
  if (!node.has("spring")) return;
  const JsonNode spring = node.at("spring");
  if (free == FREE_ANGLE)
    spring.expect_object({"stiffness", "damping", "rest", "rest_deg"});
  else
    spring.expect_object({"stiffness", "damping", "rest"});
  JointSpring& s = joint.spring.emplace();
  if (spring.has("stiffness")) s.stiffness = spring.at("stiffness").not_negative();
  if (spring.has("damping")) s.damping = spring.at("damping").not_negative();
  if (s.stiffness == 0 && s.damping == 0) spring.fail("needs a stiffness or a damping above 0");
  if (free == FREE_LENGTH) s.rest = exact::length(exact::subtract(joint.anchor_b, joint.anchor_a));
  if (!spring.has("rest_deg") && !spring.has("rest")) return;
  s.rest = free == FREE_ANGLE ? angle_at(spring, "rest", "rest_deg") : spring.at("rest").number();
  if (free == FREE_LENGTH && s.rest < 0) spring.at("rest").fail("a distance is never below 0");
}

// Keys that a kind has, and then needs, or has not.
void expect_key(const JsonNode& node, const char* kind, bool has, const char* key) {
  if (has)
    need_keys(node, kind, {key});
  else
    refuse_keys(node, kind, {key});
}

void read_anchors(const JsonNode& node, const char* kind, JointDescription& joint) {
  const bool two = has_key(joint.kind, JOINT_HAS_ANCHORS);
  refuse_keys(node, kind, {two ? "anchor" : "anchors"});
  need_keys(node, kind, {two ? "anchors" : "anchor"});
  if (two) {
    const std::vector<JsonNode> anchors = node.at("anchors").elements();
    if (anchors.size() != 2) node.at("anchors").must_be("an array of 2 points, one on either body");
    joint.anchor_a = anchors[0].vector();
    joint.anchor_b = anchors[1].vector();
  } else {
    joint.anchor_a = joint.anchor_b = node.at("anchor").vector();
  }
}

Vector3 direction(const JsonNode& node) {
  const Vector3 v = node.vector();
  if (v == Vector3{0, 0, 0}) node.fail("must not be zero: it is a direction");
  return v;
}

void read_axes(const JsonNode& node, const char* kind, JointDescription& joint) {
  const bool two = has_key(joint.kind, JOINT_HAS_AXES), one = has_key(joint.kind, JOINT_HAS_AXIS);
  refuse_keys(node, kind, {two ? "axis" : "axes"});
  expect_key(node, kind, two || one, two ? "axes" : "axis");
  if (one) joint.axis = direction(node.at("axis"));
  if (two) {
    const JsonNode axes = node.at("axes");
    const std::vector<JsonNode> pair = axes.elements();
    if (pair.size() != 2) axes.must_be("an array of 2 directions, one on either body");
    joint.axis = direction(pair[0]);
    joint.second_axis = direction(pair[1]);
    if (!exact::perpendicular(joint.axis, joint.second_axis))
      axes.fail("must be perpendicular: they are the arms of a cross");
  }
}

void read_pitch(const JsonNode& node, const char* kind, JointDescription& joint) {
  expect_key(node, kind, has_key(joint.kind, JOINT_HAS_PITCH), "pitch");
  if (!node.has("pitch")) return;
  joint.pitch = node.at("pitch").number();
  if (joint.pitch == 0) node.at("pitch").fail("must not be 0: what turns without travel is a hinge");
}

void read_radius(const JsonNode& node, const char* kind, JointDescription& joint) {
  expect_key(node, kind, has_key(joint.kind, JOINT_HAS_RADIUS), "radius");
  if (node.has("radius")) joint.radius = node.at("radius").positive();
}
}  // namespace

NamedJoint read_joint(const JsonNode& node, bool in_generator) {
  node.expect_object({"type", "name", "bodies", "anchor", "anchors", "axis", "axes", "pitch", "radius", "limits",
                      "limits_deg", "motor", "friction", "collide", "spring", "armature", "frequency", "damping"});
  NamedJoint named = {{}, {}, {false, false}, node};
  JointDescription& joint = named.joint;
  joint.kind = node.at("type").choice<JointKind>("joint", joint_names);
  const std::string word = node.at("type").text();
  const char* kind = word.c_str();
  if (node.has("name")) joint.name = node.at("name").text();

  const std::vector<JsonNode> bodies = node.at("bodies").elements();
  if (bodies.size() != 2) node.at("bodies").must_be("an array of 2 names of bodies");
  for (unsigned i = 0; i < 2; ++i) {
    std::string& name = named.names[i] = bodies[i].text();
    if (!in_generator || !name.ends_with("+1")) continue;
    named.next[i] = true;
    name.resize(name.size() - 2);
  }

  read_anchors(node, kind, joint);
  read_axes(node, kind, joint);
  read_pitch(node, kind, joint);
  read_radius(node, kind, joint);
  const JointFree free = free_of(joint.kind);
  if (free == FREE_NOTHING) refuse_keys(node, kind, {"limits", "motor", "friction", "spring", "armature"});
  if (free != FREE_ANGLE) refuse_keys(node, kind, {"limits_deg"});
  read_limits(node, free, joint);
  read_drive(node, joint);
  if (node.has("armature")) joint.armature = node.at("armature").not_negative();
  if (node.has("collide")) joint.collide = node.at("collide").boolean();
  if (is_non_holonomic(joint.kind)) refuse_keys(node, kind, {"frequency", "damping"});
  if (node.has("frequency")) joint.frequency = node.at("frequency").positive();
  if (node.has("damping")) {
    if (!node.has("frequency")) node.at("damping").fail("goes with \"frequency\"; give both");
    joint.damping = node.at("damping").not_negative();
  }
  return named;
}

double angle_at(const JsonNode& node, const char* radians, const char* degrees) {
  if (node.has(radians) && node.has(degrees))
    node.fail(fmt::format("has both {} and {}; give one", quote(radians), quote(degrees)));
  return node.has(degrees) ? node.at(degrees).number() * degree : node.at(radians).number();
}

void read_drive(const JsonNode& node, JointDescription& joint) {
  read_motor(node, free_of(joint.kind), joint);
  read_friction(node, free_of(joint.kind), joint);
  read_spring(node, free_of(joint.kind), joint);
}

std::vector<NamedJoint> read_joints(const JsonNode& array, bool in_generator) {
  std::vector<NamedJoint> joints;
  for (const JsonNode& node : array.elements()) joints.push_back(read_joint(node, in_generator));
  return joints;
}

void add_copied_joints(const std::vector<NamedJoint>& templates, const std::vector<BodyDescription>& bodies, u32 number,
                       u32 copies, const Vector3& shift, std::vector<NamedJoint>& joints) {
  for (NamedJoint named : templates) {
    if ((named.next[0] || named.next[1]) && number + 1 == copies) continue;
    for (unsigned i = 0; i < 2; ++i) {
      const bool copied = std::any_of(bodies.begin(), bodies.end(),
                                      [&](const BodyDescription& body) { return body.name == named.names[i]; });
      if (named.next[i] && !copied)
        named.node.at("bodies").fail(fmt::format("{} is no body of this generator", quote(named.names[i])));
      if (copied) named.names[i] += fmt::format("_{}", number + (named.next[i] ? 1 : 0));
      named.next[i] = false;
    }
    named.joint.anchor_a = exact::add(shift, named.joint.anchor_a);
    named.joint.anchor_b = exact::add(shift, named.joint.anchor_b);
    joints.push_back(std::move(named));
  }
}

std::vector<JointDescription> resolve_joints(const std::vector<NamedJoint>& joints,
                                             const std::vector<BodyDescription>& bodies) {
  if (joints.empty()) return {};
  std::unordered_map<std::string_view, u32> index_of;
  std::vector<std::string> names = {world_name};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].name.empty()) continue;
    index_of.emplace(bodies[i].name, static_cast<u32>(i));
    if (names.size() < 64) names.push_back(bodies[i].name);
  }
  std::vector<JointDescription> resolved;
  for (const NamedJoint& named : joints) {
    JointDescription joint = named.joint;
    const JsonNode at = named.node.at("bodies");
    for (unsigned i = 0; i < 2; ++i) {
      u32& body = i == 0 ? joint.body_a : joint.body_b;
      const auto found = index_of.find(named.names[i]);
      if (found != index_of.end()) {
        if (named.names[i] == world_name) at.fail("\"world\" is the fixed frame, and a body is called so; rename it");
        body = found->second;
        if (bodies[body].pivoted)
          at.fail(fmt::format("the body {} is on a pivot; give it a ball joint to \"world\" instead",
                              quote(named.names[i])));
      } else if (named.names[i] != world_name) {
        at.unknown("body", named.names[i], names);
      }
    }
    if (joint.body_a == joint.body_b) at.fail("names one body twice; a joint holds two");
    const auto is_dynamic = [&](u32 body) { return body != NONE && bodies[body].kind == BODY_DYNAMIC; };
    if (!is_dynamic(joint.body_a) && !is_dynamic(joint.body_b)) at.fail("one of the two must be dynamic");
    resolved.push_back(std::move(joint));
  }
  return resolved;
}

}  // namespace lockstep
