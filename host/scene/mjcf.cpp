#include "host/scene/mjcf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "host/error.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/mjcf_geoms.hpp"
#include "host/scene/mjcf_joints.hpp"
#include "host/scene/mjcf_links.hpp"
#include "host/scene/robot_files.hpp"

namespace lockstep {

namespace {

// What of a body's mass and moments each link between two of its joints takes.
constexpr double share_between = 0.05;

MjcfCompiler read_compiler(const XmlNode& top) {
  MjcfCompiler compiler;
  for (const XmlNode& node : top.children("compiler")) {
    node.expect_children({"lengthrange"});
    node.expect_attributes(
        {"autolimits",       "boundmass",     "boundinertia", "settotalmass", "balanceinertia",  "strippath",
         "coordinate",       "angle",         "fitaabb",      "eulerseq",     "meshdir",         "texturedir",
         "assetdir",         "discardvisual", "usethread",    "fusestatic",   "inertiafromgeom", "inertiagrouprange",
         "exactmeshinertia", "alignfree",     "saveinertial", "conflict"});
    const MjcfElement element(node, {});
    if (element.text("coordinate", "local") != "local") node.fail("coordinate", "must be local; MuJoCo 2.3 converts");
    for (const char* attribute : {"balanceinertia", "strippath", "alignfree"})
      if (element.choice(attribute).value_or(false))
        node.fail(attribute, "is not read; leave it out, and say it in full");
    if (node.has("inertiagrouprange")) node.fail("inertiagrouprange", "is not read; give <inertial> elements");
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

// Of those that switch off what moves bodies only gravity's is read.
void read_flags(const XmlNode& node, Robot& robot) {
  const auto is_off = [&](const char* attribute) { return node.has(attribute) && node.text(attribute) == "disable"; };
  if (is_off("gravity")) robot.gravity = Vector3{0, 0, 0};
  for (const char* attribute : {"constraint", "equality", "frictionloss", "limit", "contact", "passive", "spring",
                                "damper", "actuation", "filterparent"})
    if (is_off(attribute)) node.fail(attribute, "is not read; take what it switches off out of the file");
}

void read_option(const XmlNode& top, Robot& robot) {
  robot.dt = 0.002;
  robot.gravity = Vector3{0, 0, -9.81};
  for (const XmlNode& node : top.children("option")) {
    node.expect_attributes({"timestep",
                            "apirate",
                            "impratio",
                            "tolerance",
                            "ls_tolerance",
                            "ls_iterations",
                            "noslip_tolerance",
                            "noslip_iterations",
                            "ccd_tolerance",
                            "ccd_iterations",
                            "mpr_tolerance",
                            "mpr_iterations",
                            "sleep_tolerance",
                            "gravity",
                            "wind",
                            "magnetic",
                            "density",
                            "viscosity",
                            "o_margin",
                            "o_solref",
                            "o_solimp",
                            "o_friction",
                            "integrator",
                            "collision",
                            "cone",
                            "jacobian",
                            "solver",
                            "iterations",
                            "sdf_iterations",
                            "sdf_initpoints",
                            "actuatorgroupdisable"});
    node.expect_children({"flag"});
    const MjcfElement option(node, {});
    if (node.has("timestep")) robot.dt = node.positive("timestep");
    robot.gravity = option.vector("gravity", *robot.gravity);
    for (const char* attribute : {"density", "viscosity", "wind"})
      option.expect_zero(attribute, "is of air or water, which are not simulated; set it to 0");
    for (const XmlNode& flags : node.children("flag")) read_flags(flags, robot);
  }
}

// A body has the compiler's least mass and principal moments at least; nothing where that is no mass.
std::optional<MassProperties> bounded(MassProperties solid, const MjcfCompiler& compiler) {
  solid.mass = std::max(solid.mass, compiler.least_mass);
  if (solid.mass == 0) return std::nullopt;
  if (compiler.least_inertia == 0) return solid;
  const PrincipalAxes own = principal_axes(solid.inertia);
  MassProperties about_axes;
  bool is_raised = false;
  for (unsigned i = 0; i < 3; ++i) {
    const double moment = own.moments[i];
    const bool is_small = moment >= 0 && moment < compiler.least_inertia;  // below 0 it is none of a body
    about_axes.inertia[i] = is_small ? compiler.least_inertia : moment;
    is_raised = is_raised || is_small;
  }
  if (is_raised) solid.inertia = transformed(about_axes, {0, 0, 0}, own.rotation).inertia;
  return solid;
}

std::optional<MassProperties> read_inertial(const XmlNode& node, const MjcfCompiler& compiler) {
  node.expect_attributes({"mass", "diaginertia", "fullinertia", MJCF_POSE});
  node.expect_children({});
  const MjcfElement element(node, {});
  MassProperties own;
  own.mass = node.not_negative("mass");
  if (node.has("fullinertia")) {
    if (node.has("diaginertia")) node.fail("fullinertia", "stands beside diaginertia; give one");
    const std::vector<double> all = node.numbers("fullinertia", 6, 6);  // xx yy zz xy xz yz
    std::copy(all.begin(), all.end(), own.inertia.begin());
  } else {
    const Vector3 moments = node.vector("diaginertia");
    std::copy(moments.begin(), moments.end(), own.inertia.begin());
  }
  const std::optional<MassProperties> solid = bounded(own, compiler);
  if (!solid) return std::nullopt;
  expect_real(node, *solid);
  return transformed(*solid, node.vector("pos"), element.orientation(compiler));
}

// Tendons that only measure act on nothing, and are for other programs.
void expect_idle_tendons(const XmlNode& top, const MjcfDefaults& defaults) {
  for (const XmlNode& tendons : top.children("tendon")) {
    for (const XmlNode& node : tendons.children()) {
      const MjcfElement tendon = defaults.element(node, 0, "tendon");
      constexpr const char* cure = "is of a tendon that pulls, and those are not simulated; remove it";
      for (const char* attribute : {"stiffness", "damping", "frictionloss", "armature", "range"})
        tendon.expect_zero(attribute, cure);
    }
  }
}

class MjcfReader {
 public:
  explicit MjcfReader(const XmlNode& top)
      : compiler_(read_compiler(top)), defaults_(top), geoms_(top, compiler_, defaults_) {
    robot_.name = top.has("model") ? top.text("model") : std::filesystem::path(top.source()).stem().string();
    read_option(top, robot_);
    expect_idle_tendons(top, defaults_);
    for (const char* kind : {"actuator", "equality"}) {
      for (const XmlNode& group : top.children(kind))
        for (const XmlNode& user : group.children())
          for (const char* attribute : {"joint", "joint1", "joint2"})
            if (user.has(attribute)) used_.insert(user.text(attribute));
    }
    robot_.links.push_back({"world", top.location(), {}, {}});
    names_.links.emplace("world", 0);
    for (const XmlNode& world : top.children("worldbody")) {
      world.expect_attributes({});
      read_children(world, 0, 0, true);
    }
    if (robot_.joints.empty() && robot_.links[0].shapes.empty())
      top.fail("has no bodies and no geoms in a <worldbody>; a robot needs some");
    read_mjcf_links(top, defaults_, names_, robot_);
    robot_.contacts = geoms_.contacts(robot_.links);
    set_total_mass();
  }

  Robot take() { return std::move(robot_); }

 private:
  // Geoms and bodies of a body, which is a link.
  void read_children(const XmlNode& node, u32 link, std::size_t body_class, bool is_still) {
    const bool is_world = link == 0;
    if (is_world)
      node.expect_children({"geom", "body"}, {"site", "camera", "light"});
    else
      node.expect_children({"inertial", "joint", "freejoint", "geom", "body"}, {"site", "camera", "light"});
    using FromGeoms = MjcfCompiler::FromGeoms;
    const std::optional<XmlNode> inertial = is_still ? std::nullopt : node.child("inertial");
    const bool weighs = !is_still && (compiler_.inertia == FromGeoms::always ||
                                      (compiler_.inertia == FromGeoms::where_needed && !inertial));
    std::vector<MassProperties> solids;
    for (const XmlNode& child : node.children("geom")) {
      MjcfGeom geom = geoms_.read(defaults_.element(child, body_class, "geom"), is_still, weighs);
      for (ShapeDescription& shape : geom.shapes) robot_.links[link].shapes.push_back(std::move(shape));
      if (geom.solid) solids.push_back(*geom.solid);
    }
    if (inertial && !weighs)
      robot_.links[link].inertial = read_inertial(*inertial, compiler_);
    else if (!solids.empty())
      robot_.links[link].inertial = bounded(together(solids), compiler_);
    for (const XmlNode& child : node.children("body")) read_body(child, link, body_class, is_still);
  }

  void read_body(const XmlNode& node, u32 parent, std::size_t class_around, bool parent_is_still) {
    node.expect_attributes({"name", "childclass", "mocap", MJCF_POSE, "gravcomp", "user", "sleep"});
    const MjcfElement element(node, {});
    if (element.choice("mocap").value_or(false)) node.fail("mocap", "is not read; make it a kinematic body of a scene");
    element.expect_zero("gravcomp", "is not simulated; leave it out");
    const std::size_t body_class = node.has("childclass") ? defaults_.find(node, "childclass") : class_around;
    const std::string name = node.has("name") ? node.text("name") : fmt::format("body_{}", robot_.links.size());
    const std::string location = fmt::format("{} {}", node.location(), quote(name));
    const std::vector<MjcfJoint> joints = read_joints(node, body_class, parent);

    const u32 before = parent;
    RobotJoint first;
    first.position = element.vector("pos", {0, 0, 0});
    first.orientation = element.orientation(compiler_);
    first.name = name + ".fixed";
    first.location = location;
    u32 link = parent;
    for (std::size_t i = 0; i < std::max<std::size_t>(joints.size(), 1); ++i) {
      const bool is_last = i + 1 >= joints.size();
      RobotJoint joint = joints.empty() ? first : joints[i].joint;
      if (i == 0) {
        joint.position = first.position;
        joint.orientation = first.orientation;
      }
      joint.parent = link;
      joint.child = static_cast<u32>(robot_.links.size());
      joint.collide = heads_[before] == 0;  // what is held by the world may touch what stands there
      robot_.links.push_back({is_last ? name : name + "." + joint.name, location, {}, {}});
      if (!joints.empty()) name_joint(joints[i]);
      heads_.push_back(joint.kind == RobotJointKind::fixed ? heads_[link] : joint.child);
      link = joint.child;
      robot_.joints.push_back(std::move(joint));
    }
    if (!names_.links.emplace(name, link).second)
      node.fail("name", fmt::format("names the body {} again; names must differ", quote(name)));
    read_children(node, link, body_class, parent_is_still && joints.empty());
    share_mass(link, joints.size());
    // several joints stand between it and its parent: it is no neighbour by a joint alone
    if (joints.size() > 1 && heads_[before] != 0) robot_.passing.push_back({before, link});
  }

  std::vector<MjcfJoint> read_joints(const XmlNode& node, std::size_t body_class, u32 parent) {
    std::vector<MjcfJoint> joints;
    for (const XmlNode& child : node.children()) {
      if (child.name() == "freejoint") {
        child.expect_attributes({"name", "group", "align"});
        MjcfJoint free;
        free.joint.kind = RobotJointKind::floating;
        free.joint.name = child.has("name") ? child.text("name") : fmt::format("joint_{}", joints_read_);
        free.joint.location = child.location();
        joints.push_back(std::move(free));
      } else if (child.name() == "joint") {
        joints.push_back(read_mjcf_joint(defaults_.element(child, body_class, "joint"), compiler_, joints_read_));
      } else {
        continue;
      }
      ++joints_read_;
      const bool is_free = joints.back().joint.kind == RobotJointKind::floating;
      if (is_free && parent != 0)
        child.fail("is free, and its body is part of another one; only those of the world are");
      if (is_free ? joints.size() > 1 : joints.front().joint.kind == RobotJointKind::floating)
        child.fail("stands beside a free joint; a body that is free has no other joint");
    }
    return combined(std::move(joints), used_);
  }

  void name_joint(const MjcfJoint& in) {
    if (!names_.joints.emplace(in.joint.name, MjcfJointName{static_cast<u32>(robot_.joints.size()), in.reference})
             .second)
      throw Error(Failure::input, in.joint.location, "has the name of another joint; names must differ");
  }

  // Links between the joints of one body have a part of it, so that no mass is added.
  void share_mass(u32 link, std::size_t joints) {
    std::optional<MassProperties>& own = robot_.links[link].inertial;
    if (joints < 2 || !own) return;
    for (u32 i = 1; i < joints; ++i) robot_.links[link - i].inertial = scaled(*own, share_between);
    own = scaled(*own, 1 - share_between * static_cast<double>(joints - 1));
  }

  void set_total_mass() {
    if (compiler_.total_mass == 0) return;
    double mass = 0;
    for (const RobotLink& link : robot_.links) mass += link.inertial ? link.inertial->mass : 0;
    if (mass == 0) return;
    for (RobotLink& link : robot_.links)
      if (link.inertial) link.inertial = scaled(*link.inertial, compiler_.total_mass / mass);
  }

  const MjcfCompiler compiler_;
  const MjcfDefaults defaults_;
  MjcfGeoms geoms_;
  MjcfNames names_;
  u32 joints_read_ = 0;
  std::set<std::string> used_;    // joints that others name
  std::vector<u32> heads_ = {0};  // of each link the first of those that are fixed to each other
  Robot robot_;
};

}  // namespace

Robot parse_mjcf(const std::string& text, const std::string& source) {
  const XmlDocument document(text, source);
  const XmlNode top = document.top("mujoco", "an MJCF file");
  top.expect_attributes({"model"});
  for (const XmlNode& node : top.children("include"))
    node.fail("is not followed; let MuJoCo write all into one file: mj_saveLastXML");
  top.expect_children({"compiler", "option", "default", "asset", "worldbody", "contact", "equality", "actuator"},
                      {"tendon", "size", "visual", "statistic", "sensor", "keyframe", "custom"});
  return MjcfReader(top).take();
}

bool is_mjcf(const std::string& path) { return std::filesystem::path(path).extension() == ".xml"; }

}  // namespace lockstep
