// Elements of an MJCF document: their attributes may stand in default classes, and their orientations may be said in
// five ways, in angles that the element <compiler> chooses.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/xml_node.hpp"

namespace lockstep {

struct MjcfCompiler {
  bool degrees = true, autolimits = true;
  enum class FromGeoms { never, where_needed, always } inertia = FromGeoms::where_needed;
  double least_mass = 0, least_inertia = 0, total_mass = 0;  // kg, kg m^2; total 0: as it is
  std::string euler = "xyz";                                 // small letters: about axes that turn along
  std::string mesh_folder;
  bool strip_path = false, balance = false;  // folders of files; moments that break the triangle inequality
  double first_group = 0, last_group = 5;    // of geoms that weigh
};

/// An element, and below it, nearest first, the defaults that it has by its class.
class MjcfElement {
 public:
  MjcfElement(const XmlNode& node, std::vector<XmlNode> defaults) : node_(node), defaults_(std::move(defaults)) {}

  const XmlNode& node() const { return node_; }
  bool has(const char* attribute) const { return holder(attribute).has(attribute); }
  /// It and its defaults, the farthest first: as MuJoCo applies them.
  std::vector<XmlNode> from_farthest() const;
  /// Where the attribute stands; the element itself where it is nowhere, which then refuses to be read.
  const XmlNode& holder(const char* attribute) const;

  double number(const char* attribute, double otherwise) const;
  double not_negative(const char* attribute, double otherwise) const;
  Vector3 vector(const char* attribute, const Vector3& otherwise) const;
  std::string text(const char* attribute, const std::string& otherwise) const;
  /// A switch: true, false, or auto, which is nothing.
  std::optional<bool> choice(const char* attribute) const;
  /// Refuses one that is there and not 0: `what` says what to do.
  void expect_zero(const char* attribute, const char* what) const;

  /// An angle in radians.
  double radians(const char* attribute, double otherwise, const MjcfCompiler& compiler) const;
  /// The attributes quat, axisangle, xyaxes, zaxis and euler, of which one may be there; else no turn.
  Quaternion orientation(const MjcfCompiler& compiler) const;

 private:
  XmlNode node_;
  std::vector<XmlNode> defaults_;
};

/// An attribute of four numbers, w x y z; of any length but 0.
Quaternion quaternion_of(const XmlNode& node, const char* attribute);

/// The attributes that say where something stands.
#define MJCF_POSE "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler"

/// The tree of <default> elements.
class MjcfDefaults {
 public:
  /// All that the document has at its top.
  explicit MjcfDefaults(const XmlNode& top);
  /// An element, whose defaults are of these kinds, by its own class, else by that of the body around it, which is 0
  /// outside of bodies.
  MjcfElement element(const XmlNode& node, std::size_t body_class, std::initializer_list<std::string_view> kinds) const;
  /// The place of the class that an attribute names; refuses one that there is not.
  std::size_t find(const XmlNode& node, const char* attribute) const;

 private:
  struct Class {
    std::string name;
    std::optional<std::size_t> parent;
    std::vector<XmlNode> elements;
  };
  void add(const XmlNode& node, std::optional<std::size_t> parent);

  std::vector<Class> classes_;
};

}  // namespace lockstep
