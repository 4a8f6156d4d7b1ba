#include "host/scene/read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <unordered_map>

#include "host/embedded.hpp"
#include "host/scene/couplings.hpp"
#include "host/scene/friction_pairs.hpp"
#include "host/scene/impact_laws.hpp"
#include "host/scene/joint_kinds.hpp"
#include "host/scene/particle_law.hpp"
#include "host/scene/planar_bodies.hpp"
#include "host/scene/read_bodies.hpp"
#include "host/scene/read_robots.hpp"
#include "host/scene/renamed_keys.hpp"
#include "host/scene/sensors.hpp"
#include "host/scene/setting_table.hpp"
#include "host/scene/text_file.hpp"

namespace lockstep {

namespace {

namespace fs = std::filesystem;

// Of a material or a pair of them; what goes with what: host/scene/impact_laws.cpp.
template <class Owner>
void read_impact_law(const JsonNode& node, Owner& owner) {
  if (node.has("impact_law"))
    owner.impact_law = node.at("impact_law").choice<ImpactLaw>("law of impact", impact_law_names);
  if (node.has("tangential_restitution")) owner.tangential_restitution = node.at("tangential_restitution").number();
}

// Of a material or a pair of them; what goes with what: host/scene/friction_pairs.cpp.
FurtherFriction read_further_friction(const JsonNode& node) {
  FurtherFriction owner;
  if (node.has("static_friction")) owner.static_friction = node.at("static_friction").not_negative();
  if (node.has("stick_speed")) owner.stick_speed = node.at("stick_speed").not_negative();
  if (node.has("torsional_friction")) owner.torsional_friction = node.at("torsional_friction").not_negative();
  if (node.has("rolling_friction")) owner.rolling_friction = node.at("rolling_friction").not_negative();
  if (node.has("friction_across")) owner.friction_across = node.at("friction_across").not_negative();
  return owner;
}

std::vector<Material> read_materials(const JsonNode& array) {
  std::vector<Material> materials;
  for (const JsonNode& node : array.elements()) {
    node.expect_object({"name", "friction", "restitution", "impact_law", "tangential_restitution", "static_friction",
                        "stick_speed", "torsional_friction", "rolling_friction", "friction_across"});
    Material material;
    material.name = node.at("name").text();
    for (const Material& other : materials) {
      if (other.name == material.name) {
        node.at("name").fail(fmt::format("names the material {} again; names must differ", quote(material.name)));
      }
    }
    if (node.has("friction")) material.friction = node.at("friction").not_negative();
    if (node.has("restitution")) material.restitution = node.at("restitution").fraction();
    read_impact_law(node, material);
    material.further = read_further_friction(node);
    materials.push_back(material);
  }
  return materials;
}

std::vector<MaterialPairRule> read_material_pairs(const JsonNode& array, const std::vector<Material>& materials) {
  std::vector<std::string> names;
  for (const Material& material : materials) names.push_back(material.name);
  std::vector<MaterialPairRule> rules;
  for (const JsonNode& node : array.elements()) {
    node.expect_object({"materials", "friction", "restitution", "impact_law", "tangential_restitution",
                        "static_friction", "stick_speed", "torsional_friction", "rolling_friction"});
    const std::vector<JsonNode> pair = node.at("materials").elements();
    if (pair.size() != 2) node.at("materials").must_be("an array of 2 material names");
    u32 index[2];
    for (unsigned i = 0; i < 2; ++i) {
      const auto found = std::find(names.begin(), names.end(), pair[i].text());
      if (found == names.end()) pair[i].unknown("material", pair[i].text(), names);
      index[i] = static_cast<u32>(found - names.begin());
    }
    MaterialPairRule rule = {std::min(index[0], index[1]), std::max(index[0], index[1]),
                             node.at("friction").not_negative(), node.at("restitution").fraction()};
    read_impact_law(node, rule);
    rule.further = read_further_friction(node);
    for (const MaterialPairRule& other : rules) {
      if (other.material_a == rule.material_a && other.material_b == rule.material_b) {
        node.at("materials").fail("gives a rule for this pair again; keep one");
      }
    }
    rules.push_back(rule);
  }
  return rules;
}

CameraDescription read_camera(const JsonNode& node) {
  node.expect_object({"position", "target", "fov_deg"});
  CameraDescription camera = {node.at("position").vector(), node.at("target").vector()};
  if (camera.position == camera.target) node.at("target").fail("is where the camera is; it has to look somewhere");
  if (node.has("fov_deg")) {
    camera.fov_deg = node.at("fov_deg").number();
    if (!(camera.fov_deg >= 1 && camera.fov_deg <= 150)) node.at("fov_deg").must_be("1 .. 150");
  }
  return camera;
}

ParticleSettings read_particles(const JsonNode& node) {
  node.expect_object({"radius", "model", "sampling", "stiffness", "restitution", "friction", "shear_stiffness"});
  ParticleSettings p;
  p.radius = node.at("radius").positive();
  if (node.has("model")) {
    p.model = node.at("model").choice<ParticleModel>(
        "model", {{"penalty", ParticleModel::penalty}, {"constraints", ParticleModel::constraints}});
  }
  if (node.has("sampling")) {
    p.sampling =
        node.at("sampling").choice<Sampling>("sampling", {{"surface", Sampling::surface}, {"solid", Sampling::solid}});
  }
  if (p.model == ParticleModel::constraints) {
    for (const char* key : {"stiffness", "restitution", "friction", "shear_stiffness"}) {
      if (node.has(key))
        node.at(key).fail("belongs to the model penalty; materials say how constraints rub and bounce");
    }
    return p;
  }
  p.stiffness = node.at("stiffness").positive();
  if (node.has("restitution")) {
    p.restitution = node.at("restitution").number();
    if (!(p.restitution >= least_restitution && p.restitution <= 1))
      node.at("restitution").must_be(fmt::format("{} .. 1", least_restitution));
  }
  if (node.has("friction")) p.friction = node.at("friction").not_negative();
  if (node.has("shear_stiffness")) p.shear_stiffness = node.at("shear_stiffness").not_negative();
  return p;
}

void expect_different_names(const JsonNode& array, const std::vector<BodyDescription>& bodies) {
  std::unordered_map<std::string_view, std::size_t> index_of;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].name.empty()) continue;
    const auto [other, is_new] = index_of.try_emplace(bodies[i].name, i);
    if (is_new) continue;
    array.fail(
        fmt::format("bodies {} and {} are both named {}; names must differ", other->second, i, quote(bodies[i].name)));
  }
}

std::string stem(const std::string& path) { return fs::path(path).stem().string(); }

}  // namespace

Scene parse_scene(const std::string& text, const std::string& source, u32 seed, const RobotReading& reading) {
  if (is_robot(source)) return robot_scene(text, source, reading);
  if (!reading.keyframe.empty())
    throw Error(Failure::input, source,
                "has no keyframes, which are of MJCF files; a robot in a scene has its own: \"keyframe\"");
  const nlohmann::json document = parse_json(text, source);
  const JsonNode root(document, source);
  root.expect_object({"$schema", "name", "description", "gravity", "camera", "settings", "materials", "material_pairs",
                      "bodies", "joints", "couplings", "sensors", "particles", "robots"});
  Scene scene;
  scene.source = source;
  scene.text = text;
  scene.notes = notes_on_keys(document);
  scene.name = root.has("name") ? root.at("name").text() : stem(source);
  if (root.has("description")) scene.description = root.at("description").text();
  if (root.has("gravity")) scene.gravity = root.at("gravity").vector();
  if (root.has("camera")) scene.camera = read_camera(root.at("camera"));
  if (root.has("settings")) scene.settings = read_settings(root.at("settings"));
  if (root.has("materials")) scene.materials = read_materials(root.at("materials"));
  if (scene.materials.empty()) scene.materials.push_back({"default"});
  if (root.has("material_pairs")) {
    scene.material_pairs = read_material_pairs(root.at("material_pairs"), scene.materials);
  }
  static_cast<void>(friction_pairs_of(scene));  // both refuse
  static_cast<void>(impact_laws_of(scene));     // what does not go together
  Categories categories;
  if (root.has("particles")) scene.particles = read_particles(root.at("particles"));
  Names names = {scene.materials, categories, scene.particles.has_value(), seed};
  const bool has_robots = root.has("robots");
  BodyList list;
  if (root.has("bodies") || !has_robots) list = read_bodies(root.at("bodies"), names);
  if (root.has("joints")) {
    for (NamedJoint& joint : read_joints(root.at("joints"), false)) list.joints.push_back(std::move(joint));
  }
  scene.bodies = std::move(list.bodies);
  if (has_robots) read_robots(root.at("robots"), names, reading, scene);
  const JsonNode of_bodies = root.at(root.has("bodies") ? "bodies" : "robots");
  if (scene.bodies.empty()) of_bodies.fail("is empty; a scene needs a body");
  expect_different_names(of_bodies, scene.bodies);
  categories.expect_all_owned();
  scene.categories = categories.names();
  scene.seeded = names.seeded;
  for (JointDescription& joint : resolve_joints(list.joints, scene.bodies)) scene.joints.push_back(std::move(joint));
  for (u32 i = 0; i < scene.bodies.size(); ++i)
    if (auto joint = planar_joint_of(scene.bodies[i], i)) scene.joints.push_back(std::move(*joint));
  expect_joints_of_passing(scene);
  if (root.has("couplings"))
    for (CouplingDescription& coupling : read_couplings(root.at("couplings"), scene))
      scene.couplings.push_back(std::move(coupling));
  if (root.has("sensors")) scene.sensors = read_sensors(root.at("sensors"), scene);
  return scene;
}

Scene parse_scene(const std::string& text, const std::string& source, u32 seed) {
  return parse_scene(text, source, seed, {});
}

BodyDescription parse_body(const std::string& text, const std::string& source, Scene& scene) {
  const nlohmann::json document = parse_json(text, source);
  for (std::string& note : notes_on_keys(document)) scene.notes.push_back(std::move(note));
  const JsonNode root(document, source);
  Categories categories(scene.categories, root);
  Names names = {scene.materials, categories, scene.particles.has_value()};
  BodyDescription body = read_body(root, names);
  categories.expect_all_owned();
  scene.categories = categories.names();
  return body;
}

namespace {

JointDescription read_joint_without_bodies(nlohmann::json document, const std::string& source) {
  const JsonNode root(document, source);
  if (!root.is_object()) root.must_be("an object");
  if (root.has("bodies")) root.at("bodies").fail("is left out here: the bodies are given beside the joint");
  document["bodies"] = {"a", "b"};
  return read_joint(root, false).joint;
}

}  // namespace

JointDescription parse_joint(const std::string& text, const std::string& source) {
  return read_joint_without_bodies(parse_json(text, source), source);
}

JointDescription parse_joint_change(const std::string& text, const std::string& source, const JointDescription& joint) {
  nlohmann::json document = parse_json(text, source);
  if (document.is_object()) {
    for (const char* key : {"anchor", "anchors", "axis", "axes", "pitch", "radius"}) document.erase(key);
    const std::string type = name_of(joint.kind);
    if (document.contains("type") && document["type"] != type)
      throw Error(Failure::input, source,
                  std::string("stays a ") + noun_of(joint.kind) + "; remove it and add another");
    document["type"] = type;
    if (has_key(joint.kind, JOINT_HAS_ANCHORS))
      document["anchors"] = {joint.anchor_a, joint.anchor_b};
    else
      document["anchor"] = joint.anchor_a;
    if (has_key(joint.kind, JOINT_HAS_AXES)) document["axes"] = {joint.axis, joint.second_axis};
    if (has_key(joint.kind, JOINT_HAS_AXIS)) document["axis"] = joint.axis;
    if (has_key(joint.kind, JOINT_HAS_PITCH)) document["pitch"] = joint.pitch;
    if (has_key(joint.kind, JOINT_HAS_RADIUS)) document["radius"] = joint.radius;
  }
  return read_joint_without_bodies(std::move(document), source);
}

std::optional<CameraDescription> parse_camera(const std::string& text, const std::string& source) {
  if (is_robot(source)) return std::nullopt;
  const nlohmann::json document = parse_json(text, source);
  const JsonNode root(document, source);
  if (!root.is_object() || !root.has("camera")) return std::nullopt;
  return read_camera(root.at("camera"));
}

Scene read_scene(const std::string& path_or_name, u32 seed, const RobotReading& reading) {
  std::vector<std::string> names;
  for (const EmbeddedFile& file : embedded_scenes()) {
    names.push_back(stem(std::string(file.name)));
    if (names.back() == path_or_name) return parse_scene(std::string(file.text), std::string(file.name), seed, reading);
  }
  std::error_code ignored;
  if (!fs::exists(path_or_name, ignored)) {
    const bool is_path = path_or_name.empty() || path_or_name.find_first_of("/.") != std::string::npos;
    throw Error(Failure::input, path_or_name.empty() ? "\"\"" : path_or_name,
                is_path ? "no such file; 'lockstep scenes' lists the built-in ones"
                        : "no such file, and no built-in scene has this name; " + suggestion(path_or_name, names));
  }
  return parse_scene(read_text_file(path_or_name), path_or_name, seed, reading);
}

Scene read_scene(const std::string& path_or_name, u32 seed) { return read_scene(path_or_name, seed, {}); }

std::vector<SceneListing> built_in_scenes() {
  std::vector<SceneListing> listings;
  for (const EmbeddedFile& file : embedded_scenes()) {
    const std::string path(file.name);
    listings.push_back({stem(path), parse_scene(std::string(file.text), path).description});
  }
  std::sort(listings.begin(), listings.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return listings;
}

}  // namespace lockstep
