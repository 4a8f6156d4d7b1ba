#include "host/scene/urdf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <unordered_map>

#include "host/error.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/massless_links.hpp"
#include "host/scene/urdf_links.hpp"

namespace lockstep {

namespace {

namespace fs = std::filesystem;

// s, of a robot alone: files say none, and with that of scenes a swing of a second was off by a twentieth.
constexpr double default_dt = 0.002;

// ---- joints --------------------------------------------------------------------------------------------------------

using LinkNumbers = std::unordered_map<std::string, u32>;

RobotJointKind read_kind(const XmlNode& node) {
  constexpr std::pair<const char*, RobotJointKind> kinds[] = {
      {"fixed", RobotJointKind::fixed},           {"revolute", RobotJointKind::revolute},
      {"continuous", RobotJointKind::continuous}, {"prismatic", RobotJointKind::prismatic},
      {"planar", RobotJointKind::planar},         {"floating", RobotJointKind::floating},
      {"spherical", RobotJointKind::ball}};
  const std::string word = node.text("type");
  std::vector<std::string> names;
  for (const auto& [name, kind] : kinds) {
    if (word == name) return kind;
    names.push_back(name);
  }
  node.unknown("type", "joint", names);
}

u32 read_end(const XmlNode& joint, const char* end, const LinkNumbers& numbers, UrdfReading& reading) {
  const XmlNode node = joint.needed_child(end);
  reading.leave_out_others(node, {"link"});
  const auto found = numbers.find(node.text("link"));
  if (found != numbers.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [other, number] : numbers) known.push_back(other);
  std::sort(known.begin(), known.end());
  node.unknown("link", "link", std::move(known));
}

void read_limit(const XmlNode& node, UrdfReading& reading, RobotJoint& joint) {
  const bool is_revolute = joint.kind == RobotJointKind::revolute;
  if (!is_revolute && joint.kind != RobotJointKind::prismatic) return;
  const XmlNode limit = node.needed_child("limit");
  reading.leave_out_others(limit, {"lower", "upper", "effort", "velocity"});  // the last two are those of motors
  if (limit.has("lower")) joint.low = limit.number("lower");
  if (limit.has("upper")) joint.high = limit.number("upper");
  if (joint.low > joint.high)
    limit.fail(fmt::format("lower must not be above upper, they are {} and {}", joint.low, joint.high));
}

void read_dynamics(const XmlNode& node, UrdfReading& reading, RobotJoint& joint) {
  reading.leave_out_others(node, {"damping", "friction"});
  if (node.has("damping")) joint.damping = node.not_negative("damping");
  if (node.has("friction")) joint.friction = node.not_negative("friction");
  if (joint.kind == RobotJointKind::ball && (joint.damping > 0 || joint.friction > 0))
    node.fail("belongs to a joint with one axis, a spherical one has none; set it to 0 here");
}

bool has_one_axis(RobotJointKind kind) {
  return kind == RobotJointKind::revolute || kind == RobotJointKind::continuous || kind == RobotJointKind::prismatic;
}

void read_mimic(const XmlNode& node, UrdfReading& reading, RobotJoint& joint) {
  reading.leave_out_others(node, {"joint", "multiplier", "offset"});
  if (!has_one_axis(joint.kind)) node.fail("belongs to a joint with one axis that moves; remove it");
  RobotMimic& mimic = joint.mimic.emplace();
  mimic.leader = node.text("joint");
  if (node.has("multiplier")) mimic.multiplier = node.number("multiplier");
  if (node.has("offset")) mimic.offset = node.number("offset");
}

// Joints that follow others, each of which is there and moves along one axis, and none of them itself at last.
void expect_leaders(const XmlNode& top, const std::vector<RobotJoint>& joints) {
  const auto find = [&](const std::string& name) { return std::ranges::find(joints, name, &RobotJoint::name); };
  for (const XmlNode& node : top.children("joint")) {
    const std::optional<XmlNode> mimic = node.child("mimic");
    if (!mimic) continue;
    const auto leader = find(mimic->text("joint"));
    if (leader == joints.end()) {
      std::vector<std::string> known;
      for (const RobotJoint& joint : joints)
        if (has_one_axis(joint.kind)) known.push_back(joint.name);
      mimic->unknown("joint", "joint", std::move(known));
    }
    if (!has_one_axis(leader->kind)) mimic->fail("joint", "must be a joint with one axis that moves");
    std::size_t followed = 0;
    for (auto at = leader; at != joints.end() && at->mimic; at = find(at->mimic->leader))
      if (++followed > joints.size()) mimic->fail("joint", "follows itself, from one joint to the next");
  }
}

RobotJoint read_joint(const XmlNode& node, const LinkNumbers& numbers, UrdfReading& reading) {
  reading.leave_out_others(node, {"name", "type"}, {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"});
  RobotJoint joint;
  joint.name = node.text("name");
  joint.location = fmt::format("{} {}", node.location(), quote(joint.name));
  joint.kind = read_kind(node);
  joint.parent = read_end(node, "parent", numbers, reading);
  joint.child = read_end(node, "child", numbers, reading);
  read_urdf_origin(node, reading, joint.position, joint.orientation);
  const bool has_axis = joint.kind != RobotJointKind::fixed && joint.kind != RobotJointKind::floating &&
                        joint.kind != RobotJointKind::ball;
  if (const std::optional<XmlNode> axis = node.child("axis"); axis && has_axis) {
    reading.leave_out_others(*axis, {"xyz"});
    joint.axis = axis->vector("xyz");
    if (joint.axis == Vector3{0, 0, 0}) axis->fail("xyz", "must not be zero: it is a direction");
  }
  read_limit(node, reading, joint);
  if (const std::optional<XmlNode> mimic = node.child("mimic")) read_mimic(*mimic, reading, joint);
  if (const std::optional<XmlNode> dynamics = node.child("dynamics");
      dynamics && (has_axis || joint.kind == RobotJointKind::ball))
    read_dynamics(*dynamics, reading, joint);
  return joint;
}

// ---- the tree ------------------------------------------------------------------------------------------------------

// Sets the root, and puts parents before children.
void make_tree(const XmlNode& top, Robot& robot) {
  std::vector<const RobotJoint*> above(robot.links.size(), nullptr);
  for (const RobotJoint& joint : robot.joints) {
    const RobotJoint*& holder = above[joint.child];
    if (holder != nullptr)
      throw Error(Failure::input, joint.location,
                  fmt::format("the link {} is the child of the joint {} already; a robot is a tree",
                              quote(robot.links[joint.child].name), quote(holder->name)));
    holder = &joint;
  }
  std::vector<u32> roots;
  for (u32 i = 0; i < robot.links.size(); ++i)
    if (above[i] == nullptr) roots.push_back(i);
  if (roots.empty()) top.fail("has no link that is no child of a joint; its joints go round in a ring");
  if (roots.size() > 1)
    throw Error(Failure::input, robot.links[roots[1]].location,
                fmt::format("is held by no joint, nor is the link {}; a robot is one tree, join them",
                            quote(robot.links[roots[0]].name)));
  robot.root = roots[0];
  std::vector<std::vector<u32>> below(robot.links.size());
  for (u32 i = 0; i < robot.joints.size(); ++i) below[robot.joints[i].parent].push_back(i);
  std::vector<RobotJoint> ordered;
  std::vector<u32> links = {robot.root};
  for (std::size_t i = 0; i < links.size(); ++i) {
    for (const u32 joint : below[links[i]]) {
      ordered.push_back(robot.joints[joint]);
      links.push_back(robot.joints[joint].child);
    }
  }
  std::vector<bool> reached(robot.links.size(), false);
  for (const u32 link : links) reached[link] = true;
  const auto lost = std::find(reached.begin(), reached.end(), false);
  if (lost != reached.end())
    throw Error(Failure::input, robot.links[static_cast<std::size_t>(lost - reached.begin())].location,
                "is in a ring of joints; a robot is a tree");
  robot.joints = std::move(ordered);
}

}  // namespace

Robot parse_urdf(const std::string& text, const std::string& source, const RobotReading& robots) {
  const XmlDocument document(text, source);
  const XmlNode top = document.top("robot", "a URDF file");
  UrdfReading reading = {robots, LeftOut(robots), {}};
  reading.leave_out_others(top, {"name", "version"}, {"link", "joint", "material"});
  Robot robot;
  robot.name = top.has("name") ? top.text("name") : fs::path(source).stem().string();
  robot.dt = default_dt;
  LinkNumbers numbers;
  for (const XmlNode& node : top.children("link")) {
    robot.links.push_back(read_urdf_link(node, reading));
    if (!numbers.emplace(robot.links.back().name, static_cast<u32>(robot.links.size() - 1)).second)
      node.fail("name", fmt::format("names the link {} again; names must differ", quote(robot.links.back().name)));
  }
  if (robot.links.empty()) top.fail("has no <link>; a robot needs one");
  LinkNumbers joints;
  for (const XmlNode& node : top.children("joint")) {
    robot.joints.push_back(read_joint(node, numbers, reading));
    if (!joints.emplace(robot.joints.back().name, 0).second)
      node.fail("name", fmt::format("names the joint {} again; names must differ", quote(robot.joints.back().name)));
  }
  expect_leaders(top, robot.joints);
  make_tree(top, robot);
  for (const std::string& line : reading.left_out.lines()) robot.notes.push_back(line);
  if (!reading.mended.empty())
    robot.notes.push_back(
        fmt::format("inertia that no body has, and the nearest one is taken: {}", first_few(reading.mended)));
  settle_massless_links(robot);
  return robot;
}

bool is_urdf(const std::string& path) { return fs::path(path).extension() == ".urdf"; }

}  // namespace lockstep
