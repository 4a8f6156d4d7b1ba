#include "host/scene/mjcf_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host/scene/json_node.hpp"

namespace lockstep {

MjcfCompiler read_mjcf_compiler(const XmlNode& top) {
  MjcfCompiler compiler;
  for (const XmlNode& node : top.children("compiler")) {
    const MjcfElement element(node, {});
    if (element.text("coordinate", "local") != "local") node.fail("coordinate", "must be local; MuJoCo 2.3 converts");
    compiler.balance = element.choice("balanceinertia").value_or(compiler.balance);
    compiler.strip_path = element.choice("strippath").value_or(compiler.strip_path);
    if (node.has("inertiagrouprange")) {
      const std::vector<double> range = node.numbers("inertiagrouprange", 2, 2);
      compiler.first_group = range[0];
      compiler.last_group = range[1];
    }
    const std::string angle = element.text("angle", compiler.degrees ? "degree" : "radian");
    if (angle != "degree" && angle != "radian")
      node.fail("angle", fmt::format("must be degree or radian, is {}", quote(angle)));
    compiler.degrees = angle == "degree";
    compiler.euler = element.text("eulerseq", compiler.euler);
    if (compiler.euler.size() != 3 || compiler.euler.find_first_not_of("xyzXYZ") != std::string::npos)
      node.fail("eulerseq", fmt::format("must be three of the letters xyzXYZ, is {}", quote(compiler.euler)));
    compiler.autolimits = element.choice("autolimits").value_or(compiler.autolimits);
    if (node.has("inertiafromgeom")) {
      const std::optional<bool> from = element.choice("inertiafromgeom");
      compiler.inertia = !from   ? MjcfCompiler::FromGeoms::where_needed
                         : *from ? MjcfCompiler::FromGeoms::always
                                 : MjcfCompiler::FromGeoms::never;
    }
    compiler.least_mass = element.not_negative("boundmass", compiler.least_mass);
    compiler.least_inertia = element.not_negative("boundinertia", compiler.least_inertia);
    compiler.total_mass = std::max(0.0, element.number("settotalmass", compiler.total_mass));
    if (node.has("assetdir")) compiler.mesh_folder = node.text("assetdir");
    if (node.has("meshdir")) compiler.mesh_folder = node.text("meshdir");
  }
  return compiler;
}

namespace {

void read_flags(const XmlNode& node, MjcfFlags& flags, Robot& robot) {
  const std::pair<const char*, bool*> words[] = {{"contact", &flags.contact},
                                                 {"constraint", &flags.constraint},
                                                 {"equality", &flags.equality},
                                                 {"limit", &flags.limit},
                                                 {"frictionloss", &flags.frictionloss},
                                                 {"spring", &flags.spring},
                                                 {"damper", &flags.damper},
                                                 {"actuation", &flags.actuation},
                                                 {"clampctrl", &flags.clampctrl},
                                                 {"filterparent", &flags.filterparent}};
  const auto is_off = [&](const char* attribute) { return node.has(attribute) && node.text(attribute) == "disable"; };
  for (const auto& [word, flag] : words)
    if (is_off(word)) *flag = false;
  if (is_off("gravity")) robot.gravity = Vector3{0, 0, 0};
  if (is_off("passive")) flags.spring = flags.damper = false;  // before MuJoCo 3.3
}

}  // namespace

MjcfFlags read_mjcf_option(const XmlNode& top, Robot& robot) {
  robot.dt = 0.002;
  robot.gravity = Vector3{0, 0, -9.81};
  MjcfFlags flags;
  for (const XmlNode& node : top.children("option")) {
    if (node.has("timestep")) robot.dt = node.positive("timestep");
    if (node.has("gravity")) robot.gravity = node.vector("gravity");
  }
  for (const XmlNode& node : top.children("option"))
    for (const XmlNode& flag : node.children("flag")) read_flags(flag, flags, robot);
  return flags;
}

void switch_off(const MjcfFlags& flags, Robot& robot) {
  const bool has_limits = flags.limit && flags.constraint, has_equality = flags.equality && flags.constraint;
  for (RobotJoint& joint : robot.joints) {
    if (!has_limits && joint.kind == RobotJointKind::revolute) joint.kind = RobotJointKind::continuous;
    if (!has_limits && joint.kind == RobotJointKind::prismatic) joint.kind = RobotJointKind::sliding;
    if (!flags.frictionloss || !flags.constraint) joint.friction = 0;
    if (!flags.spring) joint.spring.reset();
    if (!flags.damper) joint.damping = 0;
    if (!has_equality) joint.locked_at.reset();
    if (!flags.filterparent) joint.collide = true;
  }
  if (!has_equality) robot.loops.clear();
  std::erase_if(robot.couplings, [&](RobotCoupling& coupling) {
    CouplingDescription& law = coupling.law;
    if (coupling.is_equality) return !has_equality;
    law.limited = law.limited && has_limits;
    if (law.spring && !flags.spring) law.spring->stiffness = 0;
    if (law.spring && !flags.damper) law.spring->damping = 0;
    if (law.spring && law.spring->stiffness == 0 && law.spring->damping == 0) law.spring.reset();
    return !law.limited && !law.spring;
  });
  if (!flags.filterparent) robot.passing.clear();
  if (!flags.contact || !flags.constraint)
    for (RobotLink& link : robot.links) link.shapes.clear();
}

}  // namespace lockstep
