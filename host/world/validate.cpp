#include "host/world/validate.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "host/scene/expect_fits.hpp"
#include "host/scene/friction_pairs.hpp"
#include "host/scene/impact_laws.hpp"
#include "host/scene/joint_kinds.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/surface.hpp"

namespace lockstep {

namespace {

// A material, or a rule for a pair of them.
template <class Owner>
void validate_values(const Settings& settings, const Owner& owner, const std::string& where) {
  constexpr double most = 1e150;  // of two materials the product counts
  const FurtherFriction& further = owner.further;
  const std::pair<const char*, std::optional<double>> values[] = {{"friction", owner.friction},
                                                                  {"static friction", further.static_friction},
                                                                  {"stick speed", further.stick_speed},
                                                                  {"torsional friction", further.torsional_friction},
                                                                  {"rolling friction", further.rolling_friction},
                                                                  {"friction across", further.friction_across}};
  for (const auto& [name, value] : values) {
    if (!value) continue;
    expect_fits(settings, *value, where + ": " + name);
    if (!(*value >= 0)) throw Error(Failure::input, where, std::string("must have no negative ") + name);
    if (*value > most) throw Error(Failure::input, where, fmt::format("must have a {} of {} at most", name, most));
  }
  if (!(owner.restitution >= 0 && owner.restitution <= 1))
    throw Error(Failure::input, where, "must have a restitution of 0 .. 1");
}

void validate(const JointSpring& spring, const JointDescription& joint, const std::string& where) {
  const auto expect = [&](bool good, const std::string& rule) {
    if (!good) throw Error(Failure::input, where, rule);
  };
  expect_finite(std::array{spring.stiffness, spring.damping, spring.rest}, where.c_str());
  expect(spring.stiffness >= 0 && spring.damping >= 0 && spring.stiffness + spring.damping > 0,
         "must have a spring with a stiffness or a damping above 0, and neither below");
  if (spring.forces != any_force) {
    expect(std::isfinite(spring.forces[0]) && std::isfinite(spring.forces[1]),
           "must have a spring whose least and most force are numbers, or neither given");
    expect(spring.forces[0] < spring.forces[1], "must have a spring whose least force is below its most");
    expect(
        joint.motor_force == 0 && joint.friction == 0,
        "must not have a motor or friction beside a spring of bounded force; give one of them to a joint of its own");
  }
  expect(free_of(joint.kind) != FREE_LENGTH || spring.rest >= 0,
         "must have a spring that rests at >= 0: a distance is never below");
}

}  // namespace

void expect_fits(const Settings& settings, std::span<const double> values, const std::string& what) {
  const std::string precision = precision_of(settings);
  const double most = precision == "float" ? std::numeric_limits<float>::max() : std::numeric_limits<double>::max();
  for (const double x : values)
    if (!(std::abs(x) <= most))
      throw Error(Failure::input, what, fmt::format("must be finite and fit {}, is {}", precision, x));
}

void expect_finite(const Wrench& load) {
  expect_finite(load.force, "force");
  expect_finite(load.torque, "torque");
}

void expect_unit(const Quaternion& q) {
  const double length = exact::length(q);
  if (!(std::abs(length - 1) < 1e-6)) throw Error(Failure::input, "orientation", "must be a unit quaternion");
}

void validate(const BodyDescription& body, const Scene& scene) {
  const std::string where = body.name.empty() ? "body" : "body \"" + body.name + "\"";
  const auto expect = [&](bool good, const char* rule) {
    if (!good) throw Error(Failure::input, where, rule);
  };
  expect_finite(body.position, where.c_str());
  expect_unit(body.orientation);
  if (body.kind == BODY_DYNAMIC) {
    expect(std::isfinite(body.mass) && body.mass > 0, "must have a mass > 0; make_solid() gives it that of its shapes");
    const Vector3& I = body.inertia;
    expect(I[0] > 0 && I[1] > 0 && I[2] > 0,
           "must have moments of inertia > 0; make_solid() gives it those of its shapes");
    for (unsigned i = 0; i < 3; ++i)
      expect(I[i] <= (I[(i + 1) % 3] + I[(i + 2) % 3]) * (1 + 1e-9), "breaks the triangle inequality of real inertias");
  }
  for (const ShapeDescription& shape : body.shapes) {
    expect(shape.kind != SHAPE_PLANE || body.kind != BODY_DYNAMIC,
           "has a plane, and only static and kinematic bodies may");
    expect(shape.kind != SHAPE_FACET || body.kind != BODY_DYNAMIC,
           "has facets of a surface, and only static and kinematic bodies may");
    expect(shape.kind != SHAPE_FACET || shape.surface, "has facets of no surface; make_surface() makes one");
    expect(shape.material < std::max<std::size_t>(scene.materials.size(), 1), "has a material that the scene does not");
  }
  precision_of(scene.settings) == "float" ? expect_fits<float>(body, where) : expect_fits<double>(body, where);
}

void validate(const JointDescription& joint, const Scene& scene) {
  const std::string where = joint.name.empty() ? "joint" : "joint \"" + joint.name + "\"";
  const auto expect = [&](bool good, const std::string& rule) {
    if (!good) throw Error(Failure::input, where, rule);
  };
  const auto is_dynamic = [&](u32 body) { return body != NONE && scene.bodies[body].kind == BODY_DYNAMIC; };
  expect(joint.body_a != joint.body_b, "names one body twice; a joint holds two");
  expect(is_dynamic(joint.body_a) || is_dynamic(joint.body_b), "one of its two bodies must be dynamic");
  for (const u32 body : {joint.body_a, joint.body_b})
    expect(body == NONE || !scene.bodies[body].pivoted,
           "holds a body on a pivot; give that a ball joint to the world instead");
  expect_finite(joint.anchor_a, where.c_str());
  expect_finite(joint.anchor_b, where.c_str());
  expect_finite(joint.axis, where.c_str());
  expect(joint.kind < JOINT_KINDS, "is of an unknown kind");
  const JointFree free = free_of(joint.kind);
  expect(!has_axis(joint.kind) || joint.axis != Vector3{0, 0, 0}, "must have an axis that is not zero");
  if (has_key(joint.kind, JOINT_HAS_AXES)) {
    expect_finite(joint.second_axis, where.c_str());
    expect(joint.second_axis != Vector3{0, 0, 0} && exact::perpendicular(joint.axis, joint.second_axis),
           "must have a second axis that is perpendicular to the first");
  }
  expect_finite(std::array{joint.low, joint.high, joint.motor_speed, joint.motor_force, joint.friction, joint.frequency,
                           joint.damping, joint.pitch, joint.radius, joint.start, joint.armature},
                where.c_str());
  expect(!has_key(joint.kind, JOINT_HAS_PITCH) || joint.pitch != 0, "must have a pitch that is not 0");
  expect(!has_key(joint.kind, JOINT_HAS_RADIUS) || joint.radius > 0, "must have a radius > 0");
  expect(!is_non_holonomic(joint.kind) || joint.frequency == 0, "cannot be soft: what slipped would not come back");
  expect(free != FREE_NOTHING || (!joint.limited && joint.motor_force == 0 && joint.friction == 0 && !joint.spring),
         "has nothing to limit, to drive or to push by a spring");
  expect(joint.armature >= 0, "must have no negative armature");
  expect(free != FREE_NOTHING || joint.armature == 0, "has no coordinate for an armature");
  expect(joint.low <= joint.high, "must not have a low limit above the high one");
  expect(free != FREE_LENGTH || joint.low >= 0, "must have limits >= 0: a distance is never below");
  expect(joint.motor_force >= 0 && joint.frequency >= 0 && joint.damping >= 0,
         "must have no negative motor force, frequency or damping");
  expect(joint.friction >= 0, "must have no negative friction");
  expect(joint.friction == 0 || joint.motor_force == 0,
         "must not have both a motor and friction; take this off the motor's force");
  if (joint.spring) validate(*joint.spring, joint, where);
  precision_of(scene.settings) == "float" ? expect_fits<float>(joint, scene, where)
                                          : expect_fits<double>(joint, scene, where);
}

void validate_materials(const Scene& scene) {
  for (const Material& material : scene.materials)
    validate_values(scene.settings, material, "material " + quote(material.name));
  for (const MaterialPairRule& rule : scene.material_pairs) validate_values(scene.settings, rule, "material pair");
  static_cast<void>(friction_pairs_of(scene));  // both refuse
  static_cast<void>(impact_laws_of(scene));     // what does not go together
}

}  // namespace lockstep
