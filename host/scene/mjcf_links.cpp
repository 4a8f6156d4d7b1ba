#include "host/scene/mjcf_links.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/scene/json_node.hpp"
#include "host/scene/mjcf_couplings.hpp"

namespace lockstep {

namespace {

class Links {
 public:
  Links(const MjcfDefaults& defaults, const MjcfNames& names, const std::string& prefix, LeftOut& left_out,
        Robot& robot)
      : defaults_(defaults),
        names_(names),
        prefix_(prefix),
        left_out_(left_out),
        robot_(robot),
        couplings_(names, prefix, left_out, robot) {}

  void read_tendon(const XmlNode& node) { couplings_.read_tendon(defaults_.element(node, 0, {"tendon"})); }

  void read_equality(const XmlNode& node) {
    const MjcfElement element = defaults_.element(node, 0, {"equality"});
    if (!element.choice("active").value_or(true)) return left_out_.add(node.location(), "inactive " + node.name());
    if (node.name() == "joint") node.has("joint2") ? couplings_.read_joints(node) : read_joint_lock(node);
    if (node.name() == "tendon") couplings_.read_tendons(node);
    if (node.name() == "connect" || node.name() == "weld") read_loop(node);
  }

  void read_contact(const XmlNode& node) {
    if (node.name() == "pair")
      left_out_.approximate(node.location(),
                            "is not read; contype and conaffinity of geoms say who touches; or run with --approximate",
                            "contact pair");
    if (node.name() != "exclude") return;
    robot_.passing.push_back({link_of(node, "body1"), link_of(node, "body2")});
  }

 private:
  u32 link_of(const XmlNode& node, const char* attribute) const {
    return find_named(names_.links, node, attribute, "body", prefix_);
  }
  const MjcfSite& site_of(const XmlNode& node, const char* attribute) const {
    return find_named(names_.sites, node, attribute, "site", prefix_);
  }

  void read_joint_lock(const XmlNode& node) {
    const MjcfJointName& name = find_named(names_.joints, node, "joint1", "joint", prefix_);
    RobotJoint& joint = robot_.joints[name.joint];
    if (joint.kind == RobotJointKind::ball || joint.kind == RobotJointKind::floating)
      node.fail("joint1", "is a joint without an axis, which nothing here drives or locks");
    joint.locked_at = node.has("polycoef") ? node.numbers("polycoef", 1, 5)[0] : 0;
  }

  void read_loop(const XmlNode& node) {
    RobotLoop loop;
    loop.name = prefix_ + (node.has("name") ? node.text("name") : fmt::format("loop_{}", robot_.loops.size()));
    loop.location = fmt::format("{} {}", node.location(), quote(loop.name));
    loop.is_ball = node.name() == "connect";
    if (node.has("site1") || node.has("site2")) {
      const MjcfSite &a = site_of(node, "site1"), &b = site_of(node, "site2");
      loop.a = a.link;
      loop.b = b.link;
      loop.sides = {{a.pose, b.pose}};
    } else {
      loop.a = link_of(node, "body1");
      loop.b = node.has("body2") ? link_of(node, "body2") : 0;
      if (loop.is_ball) loop.anchor = node.vector("anchor");
    }
    if (node.has("relpose")) {
      std::vector<double> pose = node.numbers("relpose", 1, 7);
      pose.resize(7, 0);
      // a quaternion of 0 stands for the pose at load
      if (std::ranges::any_of(pose.begin() + 3, pose.end(), [](double x) { return x != 0; }))
        loop.sides = {{{{pose[0], pose[1], pose[2]}, exact::unit(Quaternion{pose[4], pose[5], pose[6], pose[3]})}, {}}};
    }
    if (loop.a == loop.b) node.fail("names one body twice; it holds two");
    robot_.loops.push_back(std::move(loop));
  }

  const MjcfDefaults& defaults_;
  const MjcfNames& names_;
  const std::string& prefix_;
  LeftOut& left_out_;
  Robot& robot_;
  MjcfCouplings couplings_;
};

}  // namespace

void read_mjcf_links(const XmlNode& top, const MjcfDefaults& defaults, const MjcfNames& names,
                     const std::string& prefix, LeftOut& left_out, Robot& robot) {
  Links links(defaults, names, prefix, left_out, robot);
  for (const XmlNode& all : top.children("tendon"))
    for (const XmlNode& node : all.children()) links.read_tendon(node);
  for (const XmlNode& all : top.children("equality"))
    for (const XmlNode& node : all.children()) links.read_equality(node);
  for (const XmlNode& all : top.children("contact"))
    for (const XmlNode& node : all.children()) links.read_contact(node);
}

}  // namespace lockstep
