#include "host/scene/massless_links.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/scene/json_node.hpp"
#include "host/scene/left_out.hpp"

namespace lockstep {

namespace {

// What of a mass a link without any takes.
constexpr double share_of_hanging = 0.05;

// Of a link and those that are fixed to it, seen from the leaves.
struct FixedLinks {
  std::vector<u32> links;   // with a mass
  std::vector<u32> moving;  // joints from which others hang
};

// A part of the mass that hangs from a joint goes to the link that the joint is on, where it stands with the joint at
// 0.
void give_share(Robot& robot, const RobotJoint& joint, const FixedLinks& hanging) {
  std::vector<MassProperties> shares;
  for (u32 link : hanging.links) {
    std::optional<MassProperties>& own = robot.links[link].inertial;
    MassProperties share = scaled(*own, share_of_hanging);
    own = scaled(*own, 1 - share_of_hanging);
    while (link != joint.parent) {
      const auto above = std::ranges::find(robot.joints, link, &RobotJoint::child);
      share = transformed(share, above->position, above->orientation);
      link = above->parent;
    }
    shares.push_back(share);
  }
  robot.links[joint.parent].inertial = together(shares);
}

}  // namespace

void settle_massless_links(Robot& robot) {
  std::vector<FixedLinks> groups(robot.links.size());
  for (u32 i = 0; i < robot.links.size(); ++i)
    if (robot.links[i].inertial) groups[i].links.push_back(i);
  std::vector<std::string> fixed, shared;
  for (std::size_t j = robot.joints.size(); j-- > 0;) {
    RobotJoint& joint = robot.joints[j];
    FixedLinks& below = groups[joint.child];
    const bool is_light = below.links.empty() && joint.kind != RobotJointKind::fixed;
    if (is_light && below.moving.empty() && joint.kind != RobotJointKind::floating) {
      joint.kind = RobotJointKind::fixed;
      fixed.push_back(quote(robot.links[joint.child].name));
    } else if (is_light && !below.moving.empty()) {
      const RobotJoint& next = robot.joints[below.moving.front()];
      give_share(robot, next, groups[next.child]);
      below.links.push_back(next.parent);
      shared.push_back(quote(robot.links[joint.child].name));
    }
    FixedLinks& above = groups[joint.parent];
    if (joint.kind != RobotJointKind::fixed) {
      above.moving.push_back(static_cast<u32>(j));
      continue;
    }
    above.links.insert(above.links.end(), below.links.begin(), below.links.end());
    above.moving.insert(above.moving.end(), below.moving.begin(), below.moving.end());
  }
  if (!fixed.empty())
    robot.notes.push_back(fmt::format("without mass, and fixed to what they hang on: {}", first_few(fixed)));
  if (!shared.empty())
    robot.notes.push_back(
        fmt::format("without mass between two joints, with 5 % of what hangs from them: {}", first_few(shared)));
  if (!groups[robot.root].links.empty() || robot.links[robot.root].name == "world") return;
  robot.root_is_fixed = true;
  robot.notes.push_back(
      fmt::format("without mass at the root, and fixed to the world: {}", quote(robot.links[robot.root].name)));
}

}  // namespace lockstep
