#include "host/scene/read_robots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "host/embedded.hpp"
#include "host/scene/joint_kinds.hpp"
#include "host/scene/left_out.hpp"
#include "host/scene/mjcf.hpp"
#include "host/scene/text_file.hpp"
#include "host/scene/urdf.hpp"

namespace lockstep {

namespace {

namespace fs = std::filesystem;

// How long a robot that says its time step runs, unless the run is told.
constexpr double shown_seconds = 5;

// A joint that stands beyond its limits would leap back in the first step.
void start_within_limits(Robot& robot) {
  std::vector<std::string> moved;
  for (RobotJoint& joint : robot.joints) {
    if (joint.kind != RobotJointKind::revolute && joint.kind != RobotJointKind::prismatic) continue;
    const double start = std::clamp(joint.start, joint.low, joint.high);
    if (std::exchange(joint.start, start) != start) moved.push_back(quote(joint.name));
  }
  if (!moved.empty())
    robot.notes.push_back(fmt::format("starts on the nearest of its limits: {} of {} joints, {}", moved.size(),
                                      robot.joints.size(), first_few(moved)));
}

Robot parse_robot(const std::string& text, const std::string& source, const RobotReading& reading) {
  if (!is_mjcf(source) && !reading.keyframe.empty())
    throw Error(Failure::input, source, "has no keyframes, which are of MJCF files; leave the name of one out");
  Robot robot = is_mjcf(source) ? parse_mjcf(text, source, reading) : parse_urdf(text, source, reading);
  start_within_limits(robot);
  return robot;
}

// Those of the built-in scenes are in the library.
Robot read_robot_file(const JsonNode& name, const RobotReading& reading) {
  const fs::path path = fs::path(name.source()).parent_path() / name.text();
  for (const EmbeddedFile& file : embedded_robots())
    if (file.name == path.string()) return parse_robot(std::string(file.text), path.string(), reading);
  std::error_code ignored;
  if (!is_robot(path.string())) name.must_be("the name of a .urdf or .xml file");
  if (!fs::is_regular_file(path, ignored))
    name.fail(fmt::format("names no file: {} does not exist; a robot is looked for from the folder of the scene",
                          quote(name.text())));
  return parse_robot(read_text_file(path.string()), path.string(), reading);
}

// What the scene says of a joint, in the words that the scene's own joints have.
void read_robot_joint(const JsonNode& node, const Robot& robot, RobotUse& use, std::vector<bool>& said) {
  node.expect_object({"name", "start", "start_deg", "motor", "spring"});
  std::vector<std::string> known;
  for (const RobotJoint& joint : robot.joints)
    if (kind_of(joint.kind)) known.push_back(joint.name);
  const JsonNode name = node.at("name");
  const auto found = std::find_if(robot.joints.begin(), robot.joints.end(), [&](const RobotJoint& joint) {
    return joint.name == name.text() && kind_of(joint.kind);
  });
  if (found == robot.joints.end()) name.unknown("joint that moves", name.text(), known);
  const auto number = static_cast<std::size_t>(found - robot.joints.begin());
  if (said[number]) name.fail(fmt::format("names the joint {} again; say all in one place", quote(name.text())));
  said[number] = true;
  RobotDrive& drive = use.drives[number];
  JointDescription joint;
  joint.kind = *kind_of(found->kind);
  if (free_of(joint.kind) == FREE_NOTHING || has_key(joint.kind, JOINT_HAS_AXES))
    node.fail("is a joint with more than one axis; nothing starts or drives it from here");
  const bool is_angular = free_of(joint.kind) == FREE_ANGLE;
  if (found->mimic && (node.has("start") || node.has("start_deg")))
    node.fail(fmt::format("follows the joint {}, which says where it starts", quote(found->mimic->leader)));
  if (!is_angular && node.has("start_deg")) node.at("start_deg").fail("belongs to a joint that turns; give \"start\"");
  if (node.has("start") || node.has("start_deg"))
    drive.start = is_angular ? angle_at(node, "start", "start_deg") : node.at("start").number();
  if (is_angular && std::abs(drive.start.value_or(0)) > exact::largest_angle)
    node.at(node.has("start") ? "start" : "start_deg")
        .fail(fmt::format("must be an angle of {:g} rad at most", exact::largest_angle));
  read_drive(node, joint);
  const bool has_rest = joint.spring && (node.at("spring").has("rest") || node.at("spring").has("rest_deg"));
  if (joint.spring && !has_rest) joint.spring->rest = drive.start.value_or(found->start);
  drive.motor_speed = joint.motor_speed;
  drive.motor_force = joint.motor_force;
  drive.spring = joint.spring;
}

// What a robot says of its contacts becomes materials and rules for pairs of them, unless the scene has one for all.
void bring_contacts(const Robot& robot, RobotUse& use, Scene& scene) {
  if (!robot.contacts || use.material) return;
  use.first_material = static_cast<u32>(scene.materials.size());
  for (Material material : robot.contacts->materials) {
    material.name = use.name + "/" + material.name;
    scene.materials.push_back(std::move(material));
  }
  for (MaterialPairRule rule : robot.contacts->pairs) {
    rule.material_a += use.first_material;
    rule.material_b += use.first_material;
    scene.material_pairs.push_back(rule);
  }
}

void add(RobotComponents components, Scene& scene) {
  const u32 first = static_cast<u32>(scene.bodies.size()), first_joint = static_cast<u32>(scene.joints.size());
  for (BodyDescription& body : components.bodies) scene.bodies.push_back(std::move(body));
  for (JointDescription& joint : components.joints) {
    for (u32* body : {&joint.body_a, &joint.body_b})
      if (*body != NONE) *body += first;
    scene.joints.push_back(std::move(joint));
  }
  for (ActuatorDescription& actuator : components.actuators) {
    if (actuator.joint != NONE) actuator.joint += first_joint;
    scene.actuators.push_back(std::move(actuator));
  }
  for (CouplingDescription& coupling : components.couplings) {
    for (CoupledCoordinate& coupled : coupling.joints) coupled.joint += first_joint;
    scene.couplings.push_back(std::move(coupling));
  }
  for (const auto& [a, b] : components.passing) scene.passing.push_back({first + a, first + b});
}

}  // namespace

void read_robots(const JsonNode& array, Names& names, const RobotReading& reading, Scene& scene) {
  std::map<std::array<std::string, 2>, Robot> robots;  // each file and keyframe once
  BodyCounts all;
  for (const BodyDescription& body : scene.bodies) all.add(body);
  for (const JsonNode& node : array.elements()) {
    node.expect_object({"file", "keyframe", "name", "position", "orientation", "fixed", "material", "category",
                        "collides_with", "joints"});
    const JsonNode file = node.at("file");
    RobotReading own = reading;
    if (node.has("keyframe")) own.keyframe = node.at("keyframe").text();
    const auto known = robots.find({file.text(), own.keyframe});
    const bool is_new = known == robots.end();
    const Robot& robot =
        is_new ? robots.emplace(std::array{file.text(), own.keyframe}, read_robot_file(file, own)).first->second
               : known->second;
    for (const std::string& note : robot.notes)
      if (is_new) scene.notes.push_back(file.text() + ": " + note);
    RobotUse use;
    use.name = node.has("name") ? node.at("name").text() : robot.name;
    if (node.has("position")) use.position = node.at("position").vector();
    if (node.has("orientation")) use.orientation = read_orientation(node.at("orientation"));
    if (node.has("fixed")) use.fixed = node.at("fixed").boolean();
    if (node.has("material")) use.material = read_material(node.at("material"), names);
    if (node.has("category")) use.category = names.categories.own(node.at("category"));
    if (node.has("collides_with")) {
      u32 mask = 0;
      for (const JsonNode& name : node.at("collides_with").elements()) mask |= names.categories.partner(name);
      use.mask = mask;
    }
    bring_contacts(robot, use, scene);
    for (u32 k = 1; robot.contacts && !use.category && k < robot.contacts->classes; ++k)
      use.classes.push_back(names.categories.add(file, use.name + "/" + std::to_string(k)));
    use.drives.resize(robot.joints.size());
    std::vector<bool> said(robot.joints.size(), false);
    if (node.has("joints")) {
      for (const JsonNode& joint : node.at("joints").elements()) read_robot_joint(joint, robot, use, said);
    }
    RobotComponents components = make_robot(robot, use);
    for (const BodyDescription& body : components.bodies) all.add(body);
    BodyList().expect_room(node, 1, all);
    add(std::move(components), scene);
  }
}

Scene robot_scene(const std::string& text, const std::string& source, const RobotReading& reading) {
  const Robot robot = parse_robot(text, source, reading);
  Scene scene;
  scene.source = source;
  scene.text = text;
  scene.name = fs::path(source).stem().string();
  scene.description = fmt::format("The robot {}, alone", robot.name);
  scene.notes = robot.notes;
  if (robot.gravity) scene.gravity = *robot.gravity;
  if (robot.dt) {
    // light links between the joints of a body and stiff actuators want more than a few sweeps
    scene.settings.solver = Solver::small_steps;
    scene.settings.substeps = 10;
    scene.settings.dt = *robot.dt;
    scene.settings.steps = static_cast<u32>(std::clamp(std::round(shown_seconds / *robot.dt), 1.0, 1e9));
  }
  RobotUse use;
  use.name = robot.name;
  use.drives.resize(robot.joints.size());
  if (robot.contacts)
    bring_contacts(robot, use, scene);
  else
    scene.materials.push_back({"default"});
  for (u32 k = 1; robot.contacts && k < robot.contacts->classes; ++k) use.classes.push_back(1u << k);
  add(make_robot(robot, use), scene);
  if (scene.bodies.empty()) throw Error(Failure::input, source, "has no link that moves or touches anything");
  expect_joints_of_passing(scene);
  return scene;
}

void expect_joints_of_passing(const Scene& scene) {
  if (!scene.passing.empty() && scene.joints.empty())
    throw Error(
        Failure::input, scene.source,
        "has bodies that are to pass through each other (<exclude>) and no joint, and the list of such pairs is "
        "one of joints; give their geoms contype and conaffinity");
}

bool is_robot(const std::string& path) { return is_urdf(path) || is_mjcf(path); }

}  // namespace lockstep
