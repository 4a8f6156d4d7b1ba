// What can be another while a world runs: bodies, joints, materials, gravity, the bound on speeds.
#include <fmt/format.h>

#include <algorithm>

#include "host/scene/categories.hpp"
#include "host/scene/joint_kinds.hpp"
#include "host/scene/setting_table.hpp"
#include "host/world/impl.hpp"

namespace lockstep {

namespace {

// The place in the engine of what has this one in the scene, if it is there.
void add_index_before(const std::vector<u32>& index_map, u32 index, std::set<u32>& changed) {
  const auto before = std::ranges::find(index_map, index);
  if (before != index_map.end()) changed.insert(static_cast<u32>(before - index_map.begin()));
}

bool is_pair(const MaterialPairRule& a, const MaterialPairRule& b) {
  return std::minmax(a.material_a, a.material_b) == std::minmax(b.material_a, b.material_b);
}

}  // namespace

void World::Impl::change(u32 index, BodyDescription body) {
  BodyDescription& described = scene.bodies[index];
  const std::string where = bodies.called(described.name, bodies[index]);
  const bool is_dynamic = body.kind == BODY_DYNAMIC;
  for (std::size_t i = 0; i < scene.bodies.size() && !body.name.empty(); ++i)
    if (i != index && scene.bodies[i].name == body.name)
      throw Error(Failure::input, where,
                  "cannot be called " + quote(body.name) + " as another body is; names must differ");
  if (body.pivoted != described.pivoted || (body.pivoted && (!is_dynamic || body.com_offset != described.com_offset)))
    throw Error(Failure::input, where, "stays on its pivot, or without one, as it is; remove it and add another");
  for (std::size_t j = 0; j < scene.joints.size() && !is_dynamic; ++j) {
    const auto [a, b] = std::pair(scene.joints[j].body_a, scene.joints[j].body_b);
    if (a != index && b != index) continue;
    const u32 other = a == index ? b : a;
    if (other == NONE || scene.bodies[other].kind != BODY_DYNAMIC)
      throw Error(Failure::input, where,
                  "must stay dynamic while " + joints.called(scene.joints[j].name, joints[j]) +
                      " holds it to what is not; remove that first");
  }
  for (const SensorDescription& sensor : scene.sensors)
    if (sensor.body == index && sensor.shape && *sensor.shape >= body.shapes.size())
      throw Error(Failure::input, where, "must keep the shape that the sensor " + quote(sensor.name) + " measures");
  body.position = described.position;
  body.orientation = described.orientation;
  body.velocity = described.velocity;
  body.angular_velocity = described.angular_velocity;
  described = std::move(body);
  const u32 id = bodies[index].id;
  if (!is_dynamic) loads.erase(id), forces.erase(id);
  if (described.kind != BODY_KINEMATIC) targets.erase(id), arrived.erase(id);
  add_index_before(index_map.bodies, index, index_map.changed_bodies);
  change();
}

void World::Impl::change_joint(u32 index, JointDescription joint) {
  JointDescription& described = scene.joints[index];
  const std::string where = joints.called(described.name, joints[index]);
  if (joint.kind != described.kind || joint.pitch != described.pitch || joint.radius != described.radius)
    throw Error(
        Failure::input, where,
        std::string("stays a ") + noun_of(described.kind) + " of its pitch and radius; remove it and add another");
  joint.body_a = described.body_a;
  joint.body_b = described.body_b;
  joint.anchor_a = described.anchor_a;
  joint.anchor_b = described.anchor_b;
  joint.axis = described.axis;
  joint.second_axis = described.second_axis;
  joint.reference_poses = described.reference_poses;
  joint.start = described.start;
  validate(joint, scene);
  described = std::move(joint);
  add_index_before(index_map.joints, index, index_map.changed_joints);
  change();
}

void World::Impl::set_materials(std::vector<Material> materials, std::vector<MaterialPairRule> pairs,
                                const std::array<u32, 2>& pair) {
  Scene with;
  with.source = scene.source;
  with.settings = scene.settings;
  std::swap(with.materials, materials);
  std::swap(with.material_pairs, pairs);
  validate_materials(with);
  scene.materials = std::move(with.materials);
  scene.material_pairs = std::move(with.material_pairs);
  index_map.changed_materials.push_back(pair);
  change();
}

void World::change(BodyHandle body, const BodyDescription& description) {
  const u32 index = impl_->bodies.index(body);
  validate(description, impl_->scene);
  impl_->change(index, description);
}

void World::change(JointHandle joint, const JointDescription& description) {
  impl_->change_joint(impl_->joints.index(joint), description);
}

Vector3 World::gravity() const { return impl_->scene.gravity; }

void World::set_gravity(const Vector3& gravity) {
  Impl& p = *impl_;
  expect_fits(p.scene.settings, gravity, "gravity");
  if (std::ranges::any_of(p.scene.bodies, [](const BodyDescription& body) { return body.gravity_share != 1; }))
    throw Error(Failure::input, "gravity",
                "stays as it is in a world where loads hold the weight of bodies (gravcomp)");
  p.scene.gravity = gravity;
  p.gravity_set = true;
}

double World::speed_limit() const { return resolved(impl_->scene.settings).speed_limit; }

void World::set_speed_limit(double speed) {
  Settings settings = impl_->scene.settings;
  expect_fits(settings, speed, "speed_limit");
  settings.speed_limit = speed;
  expect_in_bounds(settings);
  if (precision_of(settings) == "float" && !(static_cast<float>(speed) > 0))
    throw Error(Failure::input, "speed_limit", fmt::format("must be > 0 in float, is {}", speed));
  impl_->scene.settings = std::move(settings);
  impl_->change();
}

std::span<const Material> World::materials() const { return impl_->scene.materials; }

u32 World::material(const std::string& name) const {
  const std::vector<Material>& materials = impl_->scene.materials;
  std::vector<std::string> names;
  for (const Material& material : materials) names.push_back(material.name);
  const auto found = std::ranges::find(names, name);
  if (found == names.end())
    throw Error(Failure::input, "world", "unknown material " + quote(name) + "; " + suggestion(name, names));
  return static_cast<u32>(found - names.begin());
}

void World::set_material(u32 material, const Material& values) {
  std::vector<Material> materials = impl_->scene.materials;
  if (materials.empty()) materials.emplace_back();
  if (material >= materials.size()) throw Error(Failure::input, "material", "is not in this world");
  std::string name = std::move(materials[material].name);
  materials[material] = values;
  materials[material].name = std::move(name);
  impl_->set_materials(std::move(materials), impl_->scene.material_pairs, {material, NONE});
}

void World::set_material_pair(const MaterialPairRule& rule) {
  const u32 count = static_cast<u32>(std::max<std::size_t>(impl_->scene.materials.size(), 1));
  if (rule.material_a >= count || rule.material_b >= count)
    throw Error(Failure::input, "material pair", "has a material that is not in this world");
  std::vector<MaterialPairRule> pairs = impl_->scene.material_pairs;
  const auto same = std::ranges::find_if(pairs, [&](const MaterialPairRule& other) { return is_pair(rule, other); });
  if (same == pairs.end())
    pairs.push_back(rule);
  else
    *same = rule;
  impl_->set_materials(impl_->scene.materials, std::move(pairs), {rule.material_a, rule.material_b});
}

u32 World::category_mask(const std::vector<std::string>& names) const {
  return lockstep::category_mask(impl_->scene.categories, names);
}

}  // namespace lockstep
