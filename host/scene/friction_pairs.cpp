#include "host/scene/friction_pairs.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/error.hpp"
#include "host/scene/exact_math.hpp"

namespace lockstep {

namespace {

void validate(const Scene& scene, const std::string& location, double friction, const FurtherFriction& owner) {
  const auto refuse = [&](const char* key, const std::string& what) {
    throw Error(Failure::input, fmt::format("{}: {}/{}", scene.source, location, key), what);
  };
  if (owner.static_friction && *owner.static_friction < friction)
    refuse("static_friction",
           fmt::format("must be >= the friction of what slides, {}, is {}", friction, *owner.static_friction));
  if (owner.friction_across && !(*owner.friction_across > 0 && friction > 0))
    refuse("friction_across", "must be > 0, beside a friction > 0 along the axis");
  if (owner.stick_speed && !owner.static_friction)
    refuse("stick_speed", "is up to where static_friction acts; give that too, or leave this out");
  if (owner.torsional_friction.value_or(0) > 0 && friction == 0)
    refuse("torsional_friction", "is a moment of friction, and friction is 0; give some, or leave this out");
}

double torsion_radius(double torsional, double friction) { return friction > 0 ? torsional / friction : 0; }

PairFriction meet(const Material& material_a, const Material& material_b) {
  const FurtherFriction &a = material_a.further, &b = material_b.further;
  PairFriction pair;
  // of equal materials the root is the friction itself, to the bit
  pair.sliding = pair.static_friction = exact::square_root(material_a.friction * material_b.friction);
  if (a.static_friction || b.static_friction) {
    pair.static_friction = exact::square_root(a.static_friction.value_or(material_a.friction) *
                                              b.static_friction.value_or(material_b.friction));
    if (a.stick_speed || b.stick_speed)
      pair.stick_speed = std::max(a.stick_speed.value_or(0), b.stick_speed.value_or(0));
  }
  pair.torsion_radius =
      torsion_radius(std::max(a.torsional_friction.value_or(0), b.torsional_friction.value_or(0)), pair.sliding);
  pair.rolling_coefficient = std::max(a.rolling_friction.value_or(0), b.rolling_friction.value_or(0));
  const auto anisotropy = [](const Material& m) { return m.further.friction_across.value_or(m.friction) / m.friction; };
  const auto is_anisotropic = [](const Material& m) { return m.further.friction_across && m.friction > 0; };
  pair.axis_of_b = !is_anisotropic(material_a) && is_anisotropic(material_b);
  pair.across = exact::square_root((is_anisotropic(material_a) ? anisotropy(material_a) : 1) *
                                   (is_anisotropic(material_b) ? anisotropy(material_b) : 1));
  return pair;
}

}  // namespace

std::vector<PairFriction> friction_pairs_of(const Scene& scene) {
  std::vector<Material> materials = scene.materials;
  if (materials.empty()) materials.emplace_back();
  std::vector<PairFriction> pairs;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    validate(scene, fmt::format("/materials/{}", i), materials[i].friction, materials[i].further);
    for (const Material& other : materials) pairs.push_back(meet(materials[i], other));
  }
  for (std::size_t i = 0; i < scene.material_pairs.size(); ++i) {
    const MaterialPairRule& rule = scene.material_pairs[i];
    validate(scene, fmt::format("/material_pairs/{}", i), rule.friction, rule.further);
    PairFriction& pair = pairs[rule.material_a * materials.size() + rule.material_b];
    const double torsional = rule.further.torsional_friction.value_or(pair.torsion_radius * pair.sliding);
    pair.sliding = rule.friction;
    pair.static_friction = rule.further.static_friction.value_or(rule.friction);
    if (rule.further.static_friction) pair.stick_speed = rule.further.stick_speed;
    pair.torsion_radius = torsion_radius(torsional, pair.sliding);
    pair.rolling_coefficient = rule.further.rolling_friction.value_or(pair.rolling_coefficient);
    pairs[rule.material_b * materials.size() + rule.material_a] = pair;
  }
  return pairs;
}

}  // namespace lockstep
