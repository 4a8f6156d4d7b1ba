#include "host/scene/urdf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <unordered_map>

#include "host/error.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/mesh.hpp"
#include "host/scene/robot_files.hpp"

namespace lockstep {

namespace {

namespace fs = std::filesystem;

void read_origin(const XmlNode& node, Vector3& position, Quaternion& orientation) {
  const std::optional<XmlNode> origin = node.child("origin");
  if (!origin) return;
  origin->expect_attributes({"xyz", "rpy"});
  origin->expect_children({});
  if (origin->has("xyz")) position = origin->vector("xyz");
  if (!origin->has("rpy")) return;
  const Vector3 angles = origin->vector("rpy");  // about the fixed axes x, then y, then z
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double angle = angles[axis];
    if (std::abs(angle) > exact::largest_angle)
      origin->fail("rpy", fmt::format("must be in -{0} .. {0} rad, is {1}", exact::largest_angle, angle));
    if (angle == 0) continue;
    Vector3 direction = {0, 0, 0};
    direction[axis] = 1;
    const Quaternion rotation = exact::rotation(direction, exact::sine(0.5 * angle), exact::cosine(0.5 * angle));
    orientation = exact::unit(exact::multiply(rotation, orientation));
  }
}

// ---- links ---------------------------------------------------------------------------------------------------------

// Nothing where the mass is 0, as many files have it for what is a frame alone.
std::optional<MassProperties> read_inertial(const XmlNode& node) {
  node.expect_attributes({});
  node.expect_children({"origin", "mass", "inertia"});
  Vector3 position = {0, 0, 0};
  Quaternion orientation = {0, 0, 0, 1};
  read_origin(node, position, orientation);
  const XmlNode mass = node.needed_child("mass"), inertia = node.needed_child("inertia");
  mass.expect_attributes({"value"});
  if (mass.not_negative("value") == 0) return std::nullopt;
  inertia.expect_attributes({"ixx", "ixy", "ixz", "iyy", "iyz", "izz"});
  const auto product = [&](const char* name) { return inertia.has(name) ? inertia.number(name) : 0; };
  MassProperties own;
  own.mass = mass.number("value");
  own.inertia = {inertia.positive("ixx"), inertia.positive("iyy"), inertia.positive("izz"),
                 product("ixy"),          product("ixz"),          product("iyz")};
  expect_real(inertia, own);
  return transformed(own, position, orientation);
}

// The file of a mesh: package://NAME/rest is below the nearest folder above the robot's file that is called NAME or
// holds it.
std::string mesh_path(const XmlNode& node) {
  const std::string name = node.text("filename");
  const fs::path folder = fs::path(node.source()).parent_path();
  const auto exists = [](const fs::path& path) {
    std::error_code ignored;
    return is_embedded_mesh(path.string()) || fs::is_regular_file(path, ignored);
  };
  constexpr std::string_view package = "package://", file = "file://";
  if (name.starts_with(package)) {
    const fs::path rest = name.substr(package.size());
    std::error_code ignored;
    for (fs::path above = fs::absolute(folder, ignored);; above = above.parent_path()) {
      if (exists(above / rest)) return (above / rest).lexically_normal().string();
      if (above == above.parent_path()) break;
    }
    node.fail("filename", fmt::format("{} is in no folder above the robot's file; keep the robot in its package, or "
                                      "give a path from its file",
                                      quote(name)));
  }
  const fs::path path =
      (name.starts_with(file) ? fs::path(name.substr(file.size())) : folder / name).lexically_normal();
  if (name.find("://") != name.npos && !name.starts_with(file))
    node.fail("filename", fmt::format("{} is no file here; give a path from the robot's file", quote(name)));
  if (!exists(path))
    node.fail("filename", fmt::format("names no file: {} does not exist; a mesh is looked for from the folder of the "
                                      "robot's file",
                                      quote(name)));
  return path.string();
}

void read_mesh_hull(const XmlNode& node, ShapeDescription& shape) {
  node.expect_attributes({"filename", "scale"});
  const Vector3 scale = node.has("scale") ? node.vector("scale") : Vector3{1, 1, 1};
  for (const double s : scale)
    if (s == 0) node.fail("scale", "must not be 0: the mesh would be flat");
  const std::string path = mesh_path(node);
  std::vector<Vector3> points;
  try {
    points = read_mesh(path).vertices;
  } catch (const std::runtime_error& error) {
    node.fail("filename", fmt::format("cannot be read as a mesh: {}", error.what()));
  }
  for (Vector3& p : points) p = {scale[0] * p[0], scale[1] * p[1], scale[2] * p[2]};
  shape.kind = SHAPE_HULL;
  if (const std::string refusal = set_hull_of_many(points, shape); !refusal.empty()) node.fail("filename", refusal);
}

ShapeDescription read_collision(const XmlNode& node) {
  node.expect_attributes({"name"});
  node.expect_children({"origin", "geometry"}, {"material", "contact_coefficients"});
  ShapeDescription shape;
  read_origin(node, shape.offset, shape.rotation);
  const XmlNode geometry = node.needed_child("geometry");
  geometry.expect_attributes({});
  geometry.expect_children({"box", "cylinder", "sphere", "capsule", "mesh"});
  const std::vector<XmlNode> forms = geometry.children();
  if (forms.size() != 1)
    geometry.fail(fmt::format("must hold one shape, has {}; give each a <collision>", forms.size()));
  const XmlNode& form = forms[0];
  form.expect_children({});
  if (form.name() == "mesh") {
    read_mesh_hull(form, shape);
    return shape;
  }
  if (form.name() == "box") {
    form.expect_attributes({"size"});
    shape.kind = SHAPE_BOX;
    const Vector3 size = form.vector("size");
    for (unsigned i = 0; i < 3; ++i) {
      if (!(size[i] > 0)) form.fail("size", fmt::format("must be > 0 along each axis, is {}", size[i]));
      shape.half_extents[i] = 0.5 * size[i];
    }
    return shape;
  }
  shape.kind = form.name() == "sphere" ? SHAPE_SPHERE : form.name() == "capsule" ? SHAPE_CAPSULE : SHAPE_CYLINDER;
  if (shape.kind == SHAPE_SPHERE)
    form.expect_attributes({"radius"});
  else
    form.expect_attributes({"radius", "length"});
  shape.radius = form.positive("radius");
  if (shape.kind == SHAPE_SPHERE)
    shape.rotation = {0, 0, 0, 1};
  else
    shape.half_length = 0.5 * form.positive("length");
  return shape;
}

RobotLink read_link(const XmlNode& node) {
  node.expect_attributes({"name", "type"});
  node.expect_children({"inertial", "collision", "visual"}, {"contact", "sensor", "self_collision_checking"});
  RobotLink link;
  link.name = node.text("name");
  link.location = fmt::format("{} {}", node.location(), quote(link.name));
  if (const std::optional<XmlNode> inertial = node.child("inertial")) link.inertial = read_inertial(*inertial);
  for (const XmlNode& collision : node.children("collision")) link.shapes.push_back(read_collision(collision));
  return link;
}

// ---- joints --------------------------------------------------------------------------------------------------------

using LinkNumbers = std::unordered_map<std::string, u32>;

RobotJointKind read_kind(const XmlNode& node) {
  constexpr std::pair<const char*, RobotJointKind> kinds[] = {
      {"fixed", RobotJointKind::fixed},           {"revolute", RobotJointKind::revolute},
      {"continuous", RobotJointKind::continuous}, {"prismatic", RobotJointKind::prismatic},
      {"planar", RobotJointKind::planar},         {"floating", RobotJointKind::floating}};
  const std::string word = node.text("type");
  std::vector<std::string> names;
  for (const auto& [name, kind] : kinds) {
    if (word == name) return kind;
    names.push_back(name);
  }
  node.unknown("type", "joint", names);
}

u32 read_end(const XmlNode& joint, const char* end, const LinkNumbers& numbers) {
  const XmlNode node = joint.needed_child(end);
  node.expect_attributes({"link"});
  const auto found = numbers.find(node.text("link"));
  if (found != numbers.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [other, number] : numbers) known.push_back(other);
  std::sort(known.begin(), known.end());
  node.unknown("link", "link", std::move(known));
}

void read_limit(const XmlNode& node, RobotJoint& joint) {
  const bool is_revolute = joint.kind == RobotJointKind::revolute;
  if (!is_revolute && joint.kind != RobotJointKind::prismatic) return;
  const XmlNode limit = node.needed_child("limit");
  limit.expect_attributes({"lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"});
  if (limit.has("lower")) joint.low = limit.number("lower");
  if (limit.has("upper")) joint.high = limit.number("upper");
  if (joint.low > joint.high)
    limit.fail(fmt::format("lower must not be above upper, they are {} and {}", joint.low, joint.high));
}

RobotJoint read_joint(const XmlNode& node, const LinkNumbers& numbers) {
  node.expect_attributes({"name", "type"});
  node.expect_children({"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"},
                       {"calibration", "safety_controller", "joint_properties"});
  RobotJoint joint;
  joint.name = node.text("name");
  joint.location = fmt::format("{} {}", node.location(), quote(joint.name));
  joint.kind = read_kind(node);
  joint.parent = read_end(node, "parent", numbers);
  joint.child = read_end(node, "child", numbers);
  read_origin(node, joint.position, joint.orientation);
  if (const std::optional<XmlNode> mimic = node.child("mimic"))
    mimic->fail(
        "joints that follow another one are not simulated; remove it, and give the joint a spring in the scene");
  const bool is_free = joint.kind == RobotJointKind::fixed || joint.kind == RobotJointKind::floating;
  if (const std::optional<XmlNode> axis = node.child("axis"); axis && !is_free) {
    axis->expect_attributes({"xyz"});
    joint.axis = axis->vector("xyz");
    if (joint.axis == Vector3{0, 0, 0}) axis->fail("xyz", "must not be zero: it is a direction");
  }
  read_limit(node, joint);
  if (const std::optional<XmlNode> dynamics = node.child("dynamics"); dynamics && !is_free) {
    dynamics->expect_attributes({"damping", "friction"});
    if (dynamics->has("damping")) joint.damping = dynamics->not_negative("damping");
    if (dynamics->has("friction")) joint.friction = dynamics->not_negative("friction");
  }
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

Robot parse_urdf(const std::string& text, const std::string& source) {
  const XmlDocument document(text, source);
  const XmlNode top = document.top("robot", "a URDF file");
  top.expect_attributes({"name", "version"});
  top.expect_children({"link", "joint"}, {"material", "transmission", "gazebo", "ros2_control", "sensor"});
  Robot robot;
  robot.name = top.text("name");
  LinkNumbers numbers;
  for (const XmlNode& node : top.children("link")) {
    robot.links.push_back(read_link(node));
    if (!numbers.emplace(robot.links.back().name, static_cast<u32>(robot.links.size() - 1)).second)
      node.fail("name", fmt::format("names the link {} again; names must differ", quote(robot.links.back().name)));
  }
  if (robot.links.empty()) top.fail("has no <link>; a robot needs one");
  LinkNumbers joints;
  for (const XmlNode& node : top.children("joint")) {
    robot.joints.push_back(read_joint(node, numbers));
    if (!joints.emplace(robot.joints.back().name, 0).second)
      node.fail("name", fmt::format("names the joint {} again; names must differ", quote(robot.joints.back().name)));
  }
  make_tree(top, robot);
  return robot;
}

bool is_urdf(const std::string& path) { return fs::path(path).extension() == ".urdf"; }

}  // namespace lockstep
