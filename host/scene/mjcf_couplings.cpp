#include "host/scene/mjcf_couplings.hpp"

#include <fmt/format.h>

#include "host/scene/joint_kinds.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/robot.hpp"

namespace lockstep {

namespace {

bool pulls(const MjcfElement& tendon, const char* attribute) {
  if (!tendon.has(attribute)) return false;
  const std::vector<double> values = tendon.holder(attribute).numbers(attribute, 1, 16);
  return std::ranges::any_of(values, [](double value) { return value != 0; });
}

}  // namespace

u32 MjcfCouplings::coordinate_of(const XmlNode& node, const char* attribute) const {
  const u32 joint = find_named(names_.joints, node, attribute, "joint", prefix_).joint;
  const std::optional<JointKind> kind = kind_of(robot_.joints[joint].kind);
  if (!kind || free_of(*kind) == FREE_NOTHING) node.fail(attribute, "is a joint without an axis");
  return joint;
}

MjcfCouplings::Sum MjcfCouplings::joints_of(const XmlNode& fixed, double& at_reference) const {
  Sum sum;
  for (const XmlNode& node : fixed.children("joint")) {
    const double ratio = node.number("coef");
    if (ratio == 0) continue;
    at_reference += ratio * find_named(names_.joints, node, "joint", "joint", prefix_).reference;
    add_to(sum, {coordinate_of(node, "joint"), ratio});
  }
  return sum;
}

void MjcfCouplings::add_to(Sum& sum, const CoupledCoordinate& more) {
  const auto found = std::ranges::find(sum, more.joint, &CoupledCoordinate::joint);
  if (found == sum.end())
    sum.push_back(more);
  else if ((found->ratio += more.ratio) == 0)
    sum.erase(found);
}

double MjcfCouplings::first_of(const MjcfElement& tendon, const char* attribute) {
  if (!tendon.has(attribute)) return 0;
  const XmlNode& holder = tendon.holder(attribute);
  const std::vector<double> values = holder.numbers(attribute, 1, 16);
  if (std::any_of(values.begin() + 1, values.end(), [](double value) { return value != 0; }))
    left_out_.approximate(holder.location() + " " + attribute,
                          "is not linear, which is not simulated; give one number, or run with --approximate",
                          fmt::format("fixed tendon nonlinear {}", attribute));
  if (values[0] < 0) holder.fail(attribute, fmt::format("must be >= 0, is {}", values[0]));
  return values[0];
}

// Lengths of the file are those of coordinates of the file; -1 stands for that at the reference.
std::optional<JointSpring> MjcfCouplings::spring_of(const MjcfElement& tendon, double at_reference) {
  JointSpring spring = {first_of(tendon, "stiffness"), first_of(tendon, "damping")};
  if (spring.stiffness == 0 && spring.damping == 0) return std::nullopt;
  if (!tendon.has("springlength")) return spring;
  const XmlNode& holder = tendon.holder("springlength");
  const std::vector<double> lengths = holder.numbers("springlength", 1, 2);
  if (lengths.size() == 2 && lengths[0] != lengths[1] && spring.stiffness > 0)
    left_out_.approximate(holder.location() + " springlength",
                          "has a range in which the spring does not pull, which is not simulated; give one number, or "
                          "run with --approximate",
                          "fixed tendon springlength");
  if (lengths[0] != -1) spring.rest = 0.5 * (lengths[0] + lengths.back()) - at_reference;
  return spring;
}

void MjcfCouplings::read_tendon(const MjcfElement& tendon) {
  const XmlNode& node = tendon.node();
  const bool is_fixed = node.name() == "fixed";
  const bool is_limited = tendon.has("range") && tendon.choice("limited").value_or(true);
  for (const char* attribute : {"stiffness", "damping", "frictionloss", "armature", "range"}) {
    const std::string_view word = attribute;
    if ((is_fixed && word != "frictionloss" && word != "armature") || !pulls(tendon, attribute) ||
        (word == "range" && !is_limited))
      continue;
    left_out_.approximate(tendon.holder(attribute).location() + " " + attribute,
                          is_fixed ? "is of a tendon and not simulated; remove it, or run with --approximate"
                                   : "is of a tendon that pulls, and spatial ones are not simulated; remove it, or run "
                                     "with --approximate",
                          node.name() + (is_fixed ? " tendon " + std::string(word) : " tendon"));
    if (!is_fixed) return;
  }
  if (!is_fixed) return left_out_.add(node.location(), "spatial tendon");
  double at_reference = 0;
  RobotCoupling coupling;
  CouplingDescription& law = coupling.law;
  law.joints = joints_of(node, at_reference);
  if (node.has("name")) tendons_[prefix_ + node.text("name")] = law.joints;
  law.limited = is_limited;
  if (is_limited) {
    const std::vector<double> range = tendon.holder("range").numbers("range", 2, 2);
    if (range[0] > range[1])
      tendon.holder("range").fail("range",
                                  fmt::format("must not begin above its end, is {} to {}", range[0], range[1]));
    law.low = range[0] - at_reference;
    law.high = range[1] - at_reference;
  }
  law.spring = spring_of(tendon, at_reference);
  if (law.joints.empty() || (!law.limited && !law.spring)) return left_out_.add(node.location(), "fixed tendon");
  coupling.name = prefix_ + (node.has("name") ? node.text("name") : fmt::format("tendon_{}", robot_.couplings.size()));
  robot_.couplings.push_back(std::move(coupling));
}

const MjcfCouplings::Sum& MjcfCouplings::tendon_of(const XmlNode& node, const char* attribute) const {
  const auto found = tendons_.find(prefix_ + node.text(attribute));
  if (found != tendons_.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [name, sum] : tendons_)
    if (name.starts_with(prefix_)) known.push_back(name.substr(prefix_.size()));
  node.unknown(attribute, "fixed tendon", std::move(known));
}

MjcfCouplings::Polynomial MjcfCouplings::polynomial_of(const XmlNode& node) {
  if (!node.has("polycoef")) return {0, 1};
  std::vector<double> all = node.numbers("polycoef", 1, 5);
  if (all.size() < 2) all.push_back(1);
  if (std::any_of(all.begin() + 2, all.end(), [](double x) { return x != 0; }))
    left_out_.approximate(node.location() + " polycoef",
                          "is not linear, which is not simulated; give two numbers, or run with --approximate",
                          fmt::format("equality {} polycoef", node.name()));
  return {all[0], all[1]};
}

// follower = constant + slope leader, from where both are at the reference.
void MjcfCouplings::add_equality(const XmlNode& node, const Sum& follower, const Polynomial& law, const Sum& leader) {
  RobotCoupling coupling;
  coupling.is_equality = true;
  coupling.law.joints = follower;
  for (const auto& [joint, ratio] : leader)
    if (law.slope != 0) add_to(coupling.law.joints, {joint, -law.slope * ratio});
  if (coupling.law.joints.empty()) node.fail("ties what is the same; remove it");
  coupling.law.limited = true;
  coupling.law.low = coupling.law.high = law.constant;
  coupling.name =
      prefix_ + (node.has("name") ? node.text("name") : fmt::format("equality_{}", robot_.couplings.size()));
  robot_.couplings.push_back(std::move(coupling));
}

void MjcfCouplings::read_joints(const XmlNode& node) {
  const u32 follower = coordinate_of(node, "joint1"), leader = coordinate_of(node, "joint2");
  add_equality(node, {{follower, 1}}, polynomial_of(node), {{leader, 1}});
}

void MjcfCouplings::read_tendons(const XmlNode& node) {
  const Sum follower = tendon_of(node, "tendon1");
  if (node.has("tendon2")) return add_equality(node, follower, polynomial_of(node), tendon_of(node, "tendon2"));
  add_equality(node, follower, {polynomial_of(node).constant, 0}, {});
}

}  // namespace lockstep
