// The bodies of a scene file: single ones, and generators that place many.
#pragma once

#include <string>
#include <vector>

#include "host/scene/json_node.hpp"
#include "host/scene/read_joints.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// A scene may have this many bodies and this many shapes.
constexpr u32 most_bodies = 2000000;

/// Angles in degrees may have this size.
constexpr double most_degrees = 1e6;

/// Names of collision categories, mapped to bits in the order in which the file mentions them; bit 0 is "default".
class Categories {
 public:
  Categories() = default;
  /// Those of a scene that was read from `document`.
  Categories(const std::vector<std::string>& names, const JsonNode& document);
  /// In the order of their bits.
  std::vector<std::string> names() const;
  /// The bit of a shape's own category.
  u32 own(const JsonNode& name);
  /// The bit of a category that a shape collides with.
  u32 partner(const JsonNode& name);
  /// The bit of a new category of some shapes, which nothing else calls so.
  u32 add(const JsonNode& node, const std::string& name);
  /// Refuses partners that no shape belongs to.
  void expect_all_owned() const;

 private:
  struct Category {
    std::string name;
    JsonNode first;  // where the file mentions it first
    bool owned;
  };
  Category& find(const JsonNode& name);

  std::vector<Category> categories_;
};

/// How much of a scene some bodies are: a surface is one shape, and its triangles are counted apart.
struct BodyCounts {
  std::size_t bodies = 0, shapes = 0, triangles = 0;

  void add(const BodyDescription& body);
};

/// Bodies in file order.
struct BodyList {
  std::vector<BodyDescription> bodies;
  std::vector<NamedJoint> joints;  // that generators placed
  BodyCounts counts = {};          // of the bodies

  /// Refuses, at the entry that asks for them, more than a scene may have: copies of other bodies.
  void expect_room(const JsonNode& entry, double copies, const BodyCounts& others) const;
  void add(BodyDescription body);
};

/// What bodies refer to by name.
struct Names {
  const std::vector<Material>& materials;  // those of the file; robots may bring more
  Categories& categories;
  bool particles = false;  // whether bodies are particles, as meshes must be
  u32 seed = 0;            // of all that is drawn at random
  bool seeded = false;     // something was
};

/// Copies of a generator count up from their seed: those of two seeds do not meet.
constexpr u32 seed_stride = 1000003;

/// Reads a body that no generator places.
BodyDescription read_body(const JsonNode& node, Names& names);

/// Reads the array of bodies and generators, in file order; the copies of a generator stand where it stands.
BodyList read_bodies(const JsonNode& array, Names& names);

/// A turn: a quaternion [x, y, z, w], {"axis", "angle" | "angle_deg"} or {"euler_deg"}.
Quaternion read_orientation(const JsonNode& node);

/// The number of a material that is called so.
u32 read_material(const JsonNode& name, const Names& names);

/// A vector that is not zero.
Vector3 read_direction(const JsonNode& node);

}  // namespace lockstep
