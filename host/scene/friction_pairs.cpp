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
  const double across = owner.friction_across.value_or(friction);
  if (owner.static_friction && friction == 0 && across > 0)
    refuse("static_friction",
           "raises friction along the axis and across it alike, and that along it is 0; leave one out");
  if (owner.stick_speed && !owner.static_friction)
    refuse("stick_speed", "is up to where static_friction acts; give that too, or leave this out");
  if (owner.torsional_friction.value_or(0) > 0 && friction == 0 && across == 0)
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
  const auto across = [](const Material& m) { return m.further.friction_across.value_or(m.friction); };
  const auto is_anisotropic = [&](const Material& m) {
    return m.further.friction_across && (m.friction > 0 || across(m) > 0);
  };
  pair.axis_of_b = !is_anisotropic(material_a) && is_anisotropic(material_b);
  pair.perpendicular = pair.sliding == 0 && across(material_a) > 0 && across(material_b) > 0;
  if (pair.perpendicular) {
    const auto raise = [](const Material& m) {
      return m.friction > 0 ? m.further.static_friction.value_or(m.friction) / m.friction : 1;
    };
    pair.sliding = exact::square_root(across(material_a) * across(material_b));
    pair.static_friction = pair.sliding * exact::square_root(raise(material_a) * raise(material_b));
    pair.across = 0;
  } else if (pair.sliding > 0) {
    const auto anisotropy = [&](const Material& m) { return is_anisotropic(m) ? across(m) / m.friction : 1; };
    pair.across = exact::square_root(anisotropy(material_a) * anisotropy(material_b));
  }
  pair.torsion_radius =
      torsion_radius(std::max(a.torsional_friction.value_or(0), b.torsional_friction.value_or(0)), pair.sliding);
  pair.rolling_coefficient = std::max(a.rolling_friction.value_or(0), b.rolling_friction.value_or(0));
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
