#include "host/scene/mjcf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "host/error.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/mjcf_actuators.hpp"
#include "host/scene/mjcf_geoms.hpp"
#include "host/scene/mjcf_include.hpp"
#include "host/scene/mjcf_joints.hpp"
#include "host/scene/mjcf_keyframe.hpp"
#include "host/scene/mjcf_links.hpp"
#include "host/scene/mjcf_masses.hpp"
#include "host/scene/mjcf_options.hpp"
#include "host/scene/mjcf_schema.hpp"
#include "host/scene/text_file.hpp"

namespace lockstep {

namespace {

namespace fs = std::filesystem;

// What of a body's mass and moments each link between two of its joints takes.
constexpr double share_between = 0.05;

// A document, or one that is attached to it: its settings and assets are its own, and its names have a prefix.
struct MjcfModel {
  MjcfModel(const XmlNode& node, std::string before, MjcfContacts& contacts, LeftOut& left_out)
      : top(node),
        prefix(std::move(before)),
        compiler(read_mjcf_compiler(top)),
        defaults(top),
        assets(top, compiler, defaults),
        geoms(compiler, assets, contacts, left_out) {
    for (const char* kind : {"actuator", "equality", "tendon"})
      for (const XmlNode& group : top.children(kind)) add_used(group);
  }

  void add_used(const XmlNode& group) {
    for (const XmlNode& user : group.children()) {
      for (const char* attribute : {"joint", "jointinparent", "joint1", "joint2"})
        if (user.has(attribute)) used.insert(user.text(attribute));
      add_used(user);
    }
  }

  const XmlNode top;
  const std::string prefix;
  const MjcfCompiler compiler;
  const MjcfDefaults defaults;
  const MjcfAssets assets;
  MjcfGeoms geoms;
  std::set<std::string> used;  // joints that others name
};

// What is around an element of a body.
struct Scope {
  MjcfModel* model;
  std::size_t body_class;          // of those of the model
  std::optional<RobotPose> frame;  // in the body
  std::string suffix;              // of names

  std::string named(const std::string& name) const { return model->prefix + name + suffix; }
};

class MjcfReader {
 public:
  MjcfReader(const XmlNode& top, LeftOut& left_out) : left_out_(left_out), keyframe_(top, left_out) {
    robot_.name = top.has("model") ? top.text("model") : fs::path(top.source()).stem().string();
    const MjcfFlags flags = read_mjcf_option(top, robot_);
    MjcfModel& model = add_model(top, "");
    robot_.links.push_back({"world", top.location(), {}, {}});
    names_.links.emplace("world", 0);
    for (const XmlNode& world : top.children("worldbody")) read_children(world, 0, {&model, 0, {}, ""}, true);
    if (robot_.joints.empty() && robot_.links[0].shapes.empty())
      top.fail("has no bodies and no geoms in a <worldbody>; a robot needs some");
    for (const std::unique_ptr<MjcfModel>& each : models_) {
      const XmlNode& node = each->top;
      if (flags.actuation)
        read_mjcf_actuators(node, each->compiler, each->defaults, names_, each->prefix, flags.clampctrl, keyframe_,
                            left_out_, robot_);
      read_mjcf_links(node, each->defaults, names_, each->prefix, left_out_, robot_);
    }
    if (flags.actuation) keyframe_.expect_all_read();
    for (const auto& [link, joints] : several_) share_mass(link, joints);
    switch_off(flags, robot_);
    robot_.contacts = contacts_.contacts(robot_.links);
    set_total_mass(model.compiler.total_mass);
  }

  Robot take() { return std::move(robot_); }

 private:
  MjcfModel& add_model(const XmlNode& top, const std::string& prefix) {
    models_.push_back(std::make_unique<MjcfModel>(top, prefix, contacts_, left_out_));
    return *models_.back();
  }

  // Geoms and bodies of a body, which is a link.
  void read_children(const XmlNode& node, u32 link, const Scope& scope, bool is_still) {
    const MjcfCompiler& compiler = scope.model->compiler;
    using FromGeoms = MjcfCompiler::FromGeoms;
    const std::optional<XmlNode> inertial = is_still ? std::nullopt : node.child("inertial");
    const bool weighs = !is_still && (compiler.inertia == FromGeoms::always ||
                                      (compiler.inertia == FromGeoms::where_needed && !inertial));
    std::vector<MassProperties> solids;
    read_shapes(node, link, scope, is_still, weighs, solids);
    if (inertial && !weighs)
      robot_.links[link].inertial = read_mjcf_inertial(*inertial, compiler);
    else if (!solids.empty())
      robot_.links[link].inertial = bounded(together(solids), compiler);
    read_bodies(node, link, scope, is_still);
  }

  // The geoms and sites of a body, and of frames in it.
  void read_shapes(const XmlNode& node, u32 link, const Scope& scope, bool is_still, bool weighs,
                   std::vector<MassProperties>& solids) {
    const MjcfDefaults& defaults = scope.model->defaults;
    for (const XmlNode& child : node.children()) {
      const std::string kind = child.name();
      if (kind == "geom") {
        MjcfGeom geom = scope.model->geoms.read(defaults.element(child, scope.body_class, {"geom"}), is_still, weighs);
        if (scope.frame) move_into(*scope.frame, geom);
        if (geom.shape) robot_.links[link].shapes.push_back(std::move(*geom.shape));
        if (geom.solid) solids.push_back(*geom.solid);
      } else if (kind == "site" && child.has("name")) {
        const MjcfElement site = defaults.element(child, scope.body_class, {"site"});
        names_.sites.emplace(scope.named(child.text("name")),
                             MjcfSite{link, in_frame(scope, pose_of(site, scope.model->compiler))});
      } else if (kind == "frame" || kind == "replicate") {
        each_frame(child, scope,
                   [&](const Scope& inner) { read_shapes(child, link, inner, is_still, weighs, solids); });
      }
    }
  }

  // The bodies in a body, and in frames of it.
  void read_bodies(const XmlNode& node, u32 link, const Scope& scope, bool is_still) {
    for (const XmlNode& child : node.children()) {
      const std::string kind = child.name();
      if (kind == "body") read_body(child, link, scope, is_still);
      if (kind == "attach") attach(child, link, scope, is_still);
      if (kind == "frame" || kind == "replicate")
        each_frame(child, scope, [&](const Scope& inner) { read_bodies(child, link, inner, is_still); });
    }
  }

  template <class Function>
  void each_frame(const XmlNode& node, const Scope& around, const Function& function) {
    for (const char* kind : {"joint", "freejoint", "inertial"})
      if (node.child(kind)) node.child(kind)->fail("is of a body, and stands in a <frame> or <replicate>");
    const MjcfElement element(node, {});
    Scope inner = around;
    if (node.has("childclass")) inner.body_class = around.model->defaults.find(node, "childclass");
    if (node.name() == "frame") {
      inner.frame = in_frame(around, pose_of(element, around.model->compiler));
      return function(inner);
    }
    const double count = node.number("count");
    if (!(count >= 1 && count <= 100000) || count != static_cast<double>(static_cast<u32>(count)))
      node.fail("count", fmt::format("must be an integer in 1 .. 100000, is {}", count));
    const RobotPose step = {element.vector("offset", {0, 0, 0}), element.orientation(around.model->compiler)};
    const std::string separator = node.has("sep") ? node.text("sep") : "";
    const std::size_t digits = std::to_string(static_cast<u32>(count) - 1).size();
    RobotPose at = around.frame.value_or(RobotPose{});
    for (u32 i = 0; i < static_cast<u32>(count); ++i) {
      inner.frame = at;
      inner.suffix = around.suffix + fmt::format("{}{:0{}}", separator, i, digits);
      function(inner);
      at = at * step;
    }
  }

  static RobotPose pose_of(const MjcfElement& element, const MjcfCompiler& compiler) {
    RobotPose pose = {element.vector("pos", {0, 0, 0}), element.orientation(compiler)};
    if (!element.has("fromto")) return pose;
    const std::vector<double> ends = element.holder("fromto").numbers("fromto", 6, 6);
    const Vector3 from = {ends[0], ends[1], ends[2]}, to = {ends[3], ends[4], ends[5]};
    if (from == to) element.holder("fromto").fail("fromto", "must be two points, they are one");
    return {exact::scale(0.5, exact::add(from, to)), exact::rotation_from_z_to(exact::subtract(from, to))};
  }

  static RobotPose in_frame(const Scope& scope, const RobotPose& pose) {
    return scope.frame ? *scope.frame * pose : pose;
  }

  static void move_into(const RobotPose& frame, MjcfGeom& geom) {
    if (geom.solid) geom.solid = transformed(*geom.solid, frame.position, frame.orientation);
    if (!geom.shape) return;
    const RobotPose pose = frame * RobotPose{geom.shape->offset, geom.shape->rotation};
    geom.shape->offset = pose.position;
    if (geom.shape->kind != SHAPE_SPHERE) geom.shape->rotation = pose.orientation;
  }

  // A body of another model, or all that its world has.
  void attach(const XmlNode& node, u32 link, const Scope& scope, bool is_still) {
    const std::string prefix = scope.named(node.has("prefix") ? node.text("prefix") : "");
    MjcfModel& model = add_model(document_of(node, *scope.model), prefix);
    const Scope inner = {&model, 0, scope.frame, ""};
    for (const XmlNode& world : model.top.children("worldbody")) {
      if (!node.has("body")) {
        std::vector<MassProperties> solids;
        read_shapes(world, link, inner, is_still, false, solids);
        read_bodies(world, link, inner, is_still);
      } else if (const std::optional<XmlNode> body = body_called(world, node.text("body"))) {
        return read_body(*body, link, inner, is_still);
      }
    }
    if (node.has("body")) node.fail("body", fmt::format("names no body of the model: {}", quote(node.text("body"))));
  }

  static std::optional<XmlNode> body_called(const XmlNode& node, const std::string& name) {
    for (const XmlNode& child : node.children()) {
      if (child.name() == "body" && child.has("name") && child.text("name") == name) return child;
      if (child.name() == "body" || child.name() == "frame")
        if (const std::optional<XmlNode> found = body_called(child, name)) return found;
    }
    return std::nullopt;
  }

  XmlNode document_of(const XmlNode& node, const MjcfModel& model) {
    for (const XmlNode& assets : model.top.children("asset")) {
      for (const XmlNode& asset : assets.children("model")) {
        const std::string file = asset.text("file");
        if (file != node.text("model") && !(asset.has("name") && asset.text("name") == node.text("model")) &&
            fs::path(file).stem() != node.text("model"))
          continue;
        const fs::path path = file_beside(asset, model.top.source(), file);
        if (path.empty()) asset.fail("file", fmt::format("names no file: {} does not exist", quote(file)));
        if (models_.size() > 1000) asset.fail("is attached too often, or to itself");
        documents_.push_back(std::make_unique<XmlDocument>(read_text_file(path.string()), path.string()));
        const XmlNode top = documents_.back()->top("mujoco", "an MJCF file");
        follow_includes(*documents_.back(), top);
        expect_mjcf(top, left_out_);
        return top;
      }
    }
    node.fail("model", fmt::format("names no <model> of the <asset> elements: {}", quote(node.text("model"))));
  }

  void read_body(const XmlNode& node, u32 parent, const Scope& around, bool parent_is_still) {
    const MjcfElement element(node, {});
    MjcfModel& model = *around.model;
    Scope scope = {&model, around.body_class, {}, around.suffix};
    if (node.has("childclass")) scope.body_class = model.defaults.find(node, "childclass");
    const std::string name =
        node.has("name") ? scope.named(node.text("name")) : fmt::format("body_{}", robot_.links.size());
    const std::string location = fmt::format("{} {}", node.location(), quote(name));
    const RobotPose pose = in_frame(around, pose_of(element, model.compiler));
    const std::vector<MjcfJoint> joints = read_joints(node, scope, parent, pose);
    const bool is_mocap = element.choice("mocap").value_or(false);
    if (is_mocap && (parent != 0 || !joints.empty()))
      node.fail("mocap", "must be of a body of the world without joints");

    const u32 before = parent;
    RobotJoint first;
    first.kind = is_mocap ? RobotJointKind::floating : RobotJointKind::fixed;
    first.name = name + (is_mocap ? ".mocap" : ".fixed");
    first.location = location;
    u32 link = parent;
    for (std::size_t i = 0; i < std::max<std::size_t>(joints.size(), 1); ++i) {
      const bool is_last = i + 1 >= joints.size();
      RobotJoint joint = joints.empty() ? first : joints[i].joint;
      if (i == 0) {
        joint.position = pose.position;
        joint.orientation = pose.orientation;
        if (is_mocap) keyframe_.set_mocap_start(joint);
      }
      joint.parent = link;
      joint.child = static_cast<u32>(robot_.links.size());
      joint.collide = heads_[before] == 0;  // what is held by the world may touch what stands there
      robot_.links.push_back({is_last ? name : name + "." + joint.name, location, {}, {}, is_mocap});
      robot_.links.back().gravity_share = 1 - element.number("gravcomp", 0);
      if (!joints.empty()) name_joint(joints[i]);
      heads_.push_back(joint.kind == RobotJointKind::fixed ? heads_[link] : joint.child);
      link = joint.child;
      robot_.joints.push_back(std::move(joint));
    }
    if (!names_.links.emplace(name, link).second)
      node.fail("name", fmt::format("names the body {} again; names must differ", quote(name)));
    read_children(node, link, scope, is_mocap || (parent_is_still && joints.empty()));
    several_.emplace_back(link, joints.size());
    // several joints stand between it and its parent: it is no neighbour by a joint alone
    if (joints.size() > 1 && heads_[before] != 0) robot_.passing.push_back({before, link});
  }

  // `pose` is that of the body in its parent.
  std::vector<MjcfJoint> read_joints(const XmlNode& node, const Scope& scope, u32 parent, const RobotPose& pose) {
    std::vector<MjcfJoint> joints;
    for (const XmlNode& child : node.children()) {
      if (child.name() == "freejoint") {
        MjcfJoint free;
        free.joint.kind = RobotJointKind::floating;
        free.joint.name = child.has("name") ? child.text("name") : fmt::format("joint_{}", joints_read_);
        free.joint.location = child.location();
        free.joint.position = pose.position;
        free.joint.orientation = pose.orientation;
        joints.push_back(std::move(free));
      } else if (child.name() == "joint") {
        joints.push_back(read_mjcf_joint(scope.model->defaults.element(child, scope.body_class, {"joint"}),
                                         scope.model->compiler, joints_read_, left_out_));
      } else {
        continue;
      }
      ++joints_read_;
      keyframe_.set_start(joints.back().joint, joints.back().reference);
      const bool is_free = joints.back().joint.kind == RobotJointKind::floating;
      if (is_free && parent != 0)
        child.fail("is free, and its body is part of another one; only those of the world are");
      if (is_free ? joints.size() > 1 : joints.front().joint.kind == RobotJointKind::floating)
        child.fail("stands beside a free joint; a body that is free has no other joint");
    }
    std::vector<MjcfJoint> all = combined(std::move(joints), scope.model->used);
    for (MjcfJoint& joint : all) joint.joint.name = scope.named(joint.joint.name);
    return all;
  }

  void name_joint(const MjcfJoint& in) {
    const MjcfJointName name = {static_cast<u32>(robot_.joints.size()), in.reference, in.joint.armature,
                                in.actuator_forces};
    if (!names_.joints.emplace(in.joint.name, name).second)
      throw Error(Failure::input, in.joint.location, "has the name of another joint; names must differ");
  }

  // Links between the joints of one body have a part of it, so that no mass is added.
  void share_mass(u32 link, std::size_t joints) {
    std::optional<MassProperties>& own = robot_.links[link].inertial;
    if (joints < 2 || !own) return;
    for (u32 i = 1; i < joints; ++i) robot_.links[link - i].inertial = scaled(*own, share_between);
    own = scaled(*own, 1 - share_between * static_cast<double>(joints - 1));
  }

  void set_total_mass(double total) {
    double mass = 0;
    for (const RobotLink& link : robot_.links) mass += link.inertial ? link.inertial->mass : 0;
    if (total == 0 || mass == 0) return;
    for (RobotLink& link : robot_.links)
      if (link.inertial) link.inertial = scaled(*link.inertial, total / mass);
  }

  LeftOut& left_out_;
  MjcfKeyframe keyframe_;
  MjcfContacts contacts_;
  std::vector<std::unique_ptr<XmlDocument>> documents_;  // of attached models
  std::vector<std::unique_ptr<MjcfModel>> models_;       // the first is the robot's own
  MjcfNames names_;
  u32 joints_read_ = 0;
  std::vector<u32> heads_ = {0};                      // of each link the first of those that are fixed to each other
  std::vector<std::pair<u32, std::size_t>> several_;  // links and how many joints they have
  Robot robot_;
};

}  // namespace

Robot parse_mjcf(const std::string& text, const std::string& source, const RobotReading& reading) {
  XmlDocument document(text, source);
  const XmlNode top = document.top("mujoco", "an MJCF file");
  follow_includes(document, top);
  LeftOut left_out(reading);
  expect_mjcf(top, left_out);
  Robot robot = MjcfReader(top, left_out).take();
  robot.notes = left_out.lines();
  return robot;
}

bool is_mjcf(const std::string& path) { return fs::path(path).extension() == ".xml"; }

}  // namespace lockstep
