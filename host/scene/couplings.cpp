#include "host/scene/couplings.hpp"

#include <algorithm>
#include <cmath>

#include "host/error.hpp"
#include "host/scene/joint_kinds.hpp"

namespace lockstep {

namespace {

// The first joint of that name: a robot's joint can be several, between the same bodies.
u32 find_joint(const JsonNode& node, const std::vector<JointDescription>& joints) {
  const std::string name = node.text();
  const auto found = std::ranges::find(joints, name, &JointDescription::name);
  if (found == joints.end() || name.empty()) {
    std::vector<std::string> names;
    for (const JointDescription& joint : joints)
      if (!joint.name.empty() && names.size() < 64) names.push_back(joint.name);
    node.unknown("joint", name, names);
  }
  const auto is_another = [&](const JointDescription& joint) {
    return joint.name == name && (joint.body_a != found->body_a || joint.body_b != found->body_b);
  };
  if (std::ranges::any_of(joints, is_another)) node.fail("names several joints; give each a name of its own");
  return static_cast<u32>(found - joints.begin());
}

// What is wrong with a coupling, or nothing.
std::string fault_of(const CouplingDescription& coupling, const Scene& scene) {
  if (coupling.joints.empty()) return "needs a joint";
  for (std::size_t i = 0; i < coupling.joints.size(); ++i) {
    const auto& [joint, ratio] = coupling.joints[i];
    if (joint >= scene.joints.size()) return "has a joint that the scene does not have";
    if (free_of(scene.joints[joint].kind) == FREE_NOTHING)
      return "has the joint " + quote(scene.joints[joint].name) + ", which has no coordinate";
    if (!std::isfinite(ratio) || ratio == 0) return "must have finite ratios that are not 0";
    for (std::size_t k = 0; k < i; ++k)
      if (coupling.joints[k].joint == joint)
        return "names the joint " + quote(scene.joints[joint].name) + " twice; add their ratios";
  }
  if (!std::isfinite(coupling.low) || !std::isfinite(coupling.high)) return "must have finite limits";
  if (coupling.low > coupling.high) return "must not have a low limit above the high one";
  if (!coupling.limited && !coupling.spring) return "needs limits or a spring";
  if (!coupling.spring) return "";
  const JointSpring& spring = *coupling.spring;
  if (!(spring.stiffness >= 0) || !(spring.damping >= 0) || spring.stiffness + spring.damping == 0 ||
      !std::isfinite(spring.stiffness + spring.damping + spring.rest))
    return "needs a spring with a stiffness or a damping above 0, and a finite rest";
  return spring.forces == any_force ? "" : "must not bound the force of its spring";
}

void read_spring(const JsonNode& node, CouplingDescription& coupling) {
  node.expect_object({"stiffness", "damping", "rest"});
  JointSpring& spring = coupling.spring.emplace();
  if (node.has("stiffness")) spring.stiffness = node.at("stiffness").not_negative();
  if (node.has("damping")) spring.damping = node.at("damping").not_negative();
  if (node.has("rest")) spring.rest = node.at("rest").number();
}

}  // namespace

std::vector<CouplingDescription> read_couplings(const JsonNode& array, const Scene& scene) {
  std::vector<CouplingDescription> couplings;
  for (const JsonNode& node : array.elements()) {
    node.expect_object({"name", "joints", "ratios", "equals", "limits", "spring"});
    CouplingDescription coupling;
    if (node.has("name")) coupling.name = node.at("name").text();
    for (const JsonNode& name : node.at("joints").elements())
      coupling.joints.push_back({find_joint(name, scene.joints), 1});
    if (node.has("ratios")) {
      const std::vector<JsonNode> ratios = node.at("ratios").elements();
      if (ratios.size() != coupling.joints.size()) node.at("ratios").fail("must be as many as \"joints\"");
      for (std::size_t i = 0; i < ratios.size(); ++i) coupling.joints[i].ratio = ratios[i].number();
    }
    if (node.has("spring")) read_spring(node.at("spring"), coupling);
    if (node.has("limits")) {
      const std::vector<JsonNode> limits = node.at("limits").elements();
      if (limits.size() != 2) node.at("limits").must_be("an array of 2 numbers, the low and the high limit");
      coupling.low = limits[0].number();
      coupling.high = limits[1].number();
    }
    if (node.has("equals")) {
      for (const char* key : {"limits", "spring"})
        if (node.has(key)) node.at(key).fail("does not go with \"equals\", which locks the sum; give one of them");
      coupling.low = coupling.high = node.at("equals").number();
    }
    coupling.limited = node.has("limits") || !node.has("spring");
    if (const std::string fault = fault_of(coupling, scene); !fault.empty()) node.fail(fault);
    couplings.push_back(std::move(coupling));
  }
  return couplings;
}

void validate_couplings(const Scene& scene) {
  for (const CouplingDescription& coupling : scene.couplings)
    if (const std::string fault = fault_of(coupling, scene); !fault.empty())
      throw Error(Failure::input, coupling.name.empty() ? "coupling" : "coupling " + quote(coupling.name), fault);
}

}  // namespace lockstep
