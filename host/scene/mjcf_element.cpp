#include "host/scene/mjcf_element.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/scene/json_node.hpp"

namespace lockstep {

namespace {

// About an axis, by an angle in the unit of the file.
Quaternion rotation(const XmlNode& node, const char* attribute, const Vector3& axis, double angle, bool degrees) {
  const double most = degrees ? 1e6 : exact::largest_angle;
  if (std::abs(angle) > most) node.fail(attribute, fmt::format("must be in -{0} .. {0}, is {1}", most, angle));
  if (axis == Vector3{0, 0, 0}) node.fail(attribute, "must have an axis that is not zero");
  return degrees ? exact::rotation(axis, exact::sine_of_degrees(0.5 * angle), exact::cosine_of_degrees(0.5 * angle))
                 : exact::rotation(axis, exact::sine(0.5 * angle), exact::cosine(0.5 * angle));
}

Quaternion read_euler(const XmlNode& node, const MjcfCompiler& compiler) {
  const Vector3 angles = node.vector("euler");
  Quaternion q = {0, 0, 0, 1};
  for (unsigned i = 0; i < 3; ++i) {
    const char letter = compiler.euler[i];
    const bool follows_axes = letter >= 'a';
    Vector3 axis = {0, 0, 0};
    axis[static_cast<unsigned>(letter - (follows_axes ? 'x' : 'X'))] = 1;
    const Quaternion step = rotation(node, "euler", axis, angles[i], compiler.degrees);
    q = follows_axes ? exact::multiply(q, step) : exact::multiply(step, q);
  }
  return exact::unit(q);
}

Quaternion read_orientation(const XmlNode& node, const char* attribute, const MjcfCompiler& compiler) {
  const std::string_view word = attribute;
  if (word == "euler") return read_euler(node, compiler);
  if (word == "quat") return quaternion_of(node, attribute);
  if (word == "axisangle") {
    const std::vector<double> a = node.numbers("axisangle", 4, 4);
    return rotation(node, "axisangle", {a[0], a[1], a[2]}, a[3], compiler.degrees);
  }
  if (word == "zaxis") {
    const Vector3 z = node.vector("zaxis");
    if (z == Vector3{0, 0, 0}) node.fail("zaxis", "must not be zero: it is a direction");
    return exact::rotation_from_z_to(z);
  }
  const std::vector<double> a = node.numbers("xyaxes", 6, 6);
  const Vector3 x = {a[0], a[1], a[2]}, z = exact::cross(x, {a[3], a[4], a[5]});
  if (z == Vector3{0, 0, 0}) node.fail("xyaxes", "must be two directions that are not along one line");
  return exact::rotation_to_frame(z, x);
}

}  // namespace

Quaternion quaternion_of(const XmlNode& node, const char* attribute) {
  const std::vector<double> q = node.numbers(attribute, 4, 4);
  if (q == std::vector<double>(4, 0)) node.fail(attribute, "must not be zero");
  return exact::unit(Quaternion{q[1], q[2], q[3], q[0]});
}

std::vector<XmlNode> MjcfElement::from_farthest() const {
  std::vector<XmlNode> nodes(defaults_.rbegin(), defaults_.rend());
  nodes.push_back(node_);
  return nodes;
}

const XmlNode& MjcfElement::holder(const char* attribute) const {
  if (node_.has(attribute)) return node_;
  for (const XmlNode& node : defaults_)
    if (node.has(attribute)) return node;
  return node_;
}

double MjcfElement::number(const char* attribute, double otherwise) const {
  return has(attribute) ? holder(attribute).number(attribute) : otherwise;
}

double MjcfElement::not_negative(const char* attribute, double otherwise) const {
  return has(attribute) ? holder(attribute).not_negative(attribute) : otherwise;
}

Vector3 MjcfElement::vector(const char* attribute, const Vector3& otherwise) const {
  return has(attribute) ? holder(attribute).vector(attribute) : otherwise;
}

std::string MjcfElement::text(const char* attribute, const std::string& otherwise) const {
  return has(attribute) ? holder(attribute).text(attribute) : otherwise;
}

std::optional<bool> MjcfElement::choice(const char* attribute) const {
  const std::string word = text(attribute, "auto");
  if (word == "auto") return std::nullopt;
  if (word != "true" && word != "false")
    holder(attribute).fail(attribute, fmt::format("must be true, false or auto, is {}", quote(word)));
  return word == "true";
}

void MjcfElement::expect_zero(const char* attribute, const char* what) const {
  if (!has(attribute)) return;
  for (const double value : holder(attribute).numbers(attribute, 1, 16))
    if (value != 0) holder(attribute).fail(attribute, what);
}

double MjcfElement::radians(const char* attribute, double otherwise, const MjcfCompiler& compiler) const {
  if (!has(attribute)) return otherwise;
  const double angle = holder(attribute).number(attribute);
  return compiler.degrees ? angle * (exact::pi / 180) : angle;
}

Quaternion MjcfElement::orientation(const MjcfCompiler& compiler) const {
  std::vector<XmlNode> nodes = {node_};
  nodes.insert(nodes.end(), defaults_.begin(), defaults_.end());
  for (const XmlNode& node : nodes) {
    const char* given = nullptr;
    for (const char* attribute : {"quat", "axisangle", "xyaxes", "zaxis", "euler"}) {
      if (!node.has(attribute)) continue;
      if (given) node.fail(attribute, fmt::format("stands beside {}; give one orientation", given));
      given = attribute;
    }
    if (given) return read_orientation(node, given, compiler);
  }
  return {0, 0, 0, 1};
}

MjcfDefaults::MjcfDefaults(const XmlNode& top) {
  classes_.push_back({"main", std::nullopt, {}});
  for (const XmlNode& node : top.children("default")) add(node, std::nullopt);
}

void MjcfDefaults::add(const XmlNode& node, std::optional<std::size_t> parent) {
  std::size_t index = 0;
  if (parent) {
    const std::string name = node.text("class");
    for (const Class& other : classes_)
      if (other.name == name)
        node.fail("class", fmt::format("names the class {} again; names must differ", quote(name)));
    index = classes_.size();
    classes_.push_back({name, parent, {}});
  } else if (node.has("class")) {
    classes_[0].name = node.text("class");
  }
  for (const XmlNode& child : node.children()) {
    if (child.name() == "default")
      add(child, index);
    else
      classes_[index].elements.push_back(child);
  }
}

std::size_t MjcfDefaults::find(const XmlNode& node, const char* attribute) const {
  const std::string name = node.text(attribute);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < classes_.size(); ++i) {
    if (classes_[i].name == name) return i;
    names.push_back(classes_[i].name);
  }
  node.unknown(attribute, "class", std::move(names));
}

MjcfElement MjcfDefaults::element(const XmlNode& node, std::size_t body_class,
                                  std::initializer_list<std::string_view> kinds) const {
  std::optional<std::size_t> at = node.has("class") ? find(node, "class") : body_class;
  std::vector<XmlNode> defaults;
  for (; at; at = classes_[*at].parent) {
    const std::vector<XmlNode>& elements = classes_[*at].elements;
    for (auto other = elements.rbegin(); other != elements.rend(); ++other)
      if (std::ranges::find(kinds, other->name()) != kinds.end()) defaults.push_back(*other);
  }
  return {node, std::move(defaults)};
}

}  // namespace lockstep
