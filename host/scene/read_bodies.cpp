#include "host/scene/read_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/scene/generators.hpp"
#include "host/scene/read_hull.hpp"
#include "host/scene/shape_kinds.hpp"
#include "host/scene/solid_body.hpp"
#include "host/scene/surface.hpp"

namespace lockstep {

namespace {

// Keys that not all kinds have: those that this one needs, and none that do not belong to it.
void expect_keys(const JsonNode& node, ShapeKind kind) {
  for (const auto& [key, bit] : shape_keys) {
    if ((info(kind).needs & bit) != 0 && !node.has(key)) node.fail(fmt::format("needs the key {}", quote(key)));
    if (((info(kind).needs | info(kind).may) & bit) == 0 && node.has(key))
      node.at(key).fail(fmt::format("does not belong to a {}; remove it", info(kind).name));
  }
}

void read_size(const JsonNode& node, ShapeDescription& shape) {
  if (node.has("radius")) shape.radius = node.at("radius").positive();
  if (node.has("length")) shape.half_length = 0.5 * node.at("length").positive();
  if (node.has("size")) {
    const std::vector<JsonNode> edges = node.at("size").elements();
    if (edges.size() != 3) node.at("size").must_be("the three edges of a box");
    for (unsigned i = 0; i < 3; ++i) shape.half_extents[i] = 0.5 * edges[i].positive();
  }
}

ShapeDescription read_shape(const JsonNode& node, BodyKind body_kind, Names& names) {
  node.expect_object({"type", "radius", "length", "size", "points", "mesh", "scale", "heights", "spacing", "offset",
                      "normal", "rotation", "material", "category", "collides_with", "trigger"});
  ShapeDescription shape;
  shape.kind = node.at("type").choice<ShapeKind>("shape", shape_names);
  expect_keys(node, shape.kind);
  read_size(node, shape);
  if (node.has("offset")) shape.offset = node.at("offset").vector();

  if (shape.kind == SHAPE_PLANE && body_kind == BODY_DYNAMIC)
    node.fail("a plane has no end and thus no mass; its body must be static or kinematic, is dynamic");
  if (node.has("normal") && node.has("rotation")) node.fail("has both \"normal\" and \"rotation\"; give one");
  if (node.has("normal")) shape.rotation = exact::rotation_from_z_to(read_direction(node.at("normal")));
  if (node.has("rotation")) shape.rotation = read_orientation(node.at("rotation"));

  if (shape.kind == SHAPE_HULL) read_hull(node, shape);
  if (shape.kind == SHAPE_MESH && names.particles) read_solid_mesh(node, shape);
  if (shape.kind == SHAPE_MESH && !names.particles) {
    if (body_kind == BODY_DYNAMIC)
      node.fail(
          "is the mesh of a dynamic body, which collides by particles; give the scene \"particles\", or make it a "
          "hull, or the body static or kinematic");
    read_surface(node, shape);
  }
  if (shape.kind == SHAPE_FACET) {
    if (body_kind == BODY_DYNAMIC)
      node.fail("a height field has no mass; its body must be static or kinematic, is dynamic");
    if (names.particles)
      node.fail("a height field knows no particles; make it a closed mesh, or give the scene no \"particles\"");
    read_height_field(node, shape);
  }
  if (shape.surface && node.has("trigger"))
    node.at("trigger").fail(
        fmt::format("does not belong to a {}, which has no inside; remove it", info(shape.kind).name));

  if (node.has("material")) shape.material = read_material(node.at("material"), names);
  if (node.has("category")) shape.category = names.categories.own(node.at("category"));
  if (node.has("collides_with")) {
    shape.mask = 0;
    for (const JsonNode& name : node.at("collides_with").elements()) shape.mask |= names.categories.partner(name);
  }
  if (node.has("trigger")) shape.trigger = node.at("trigger").boolean();
  if (shape.surface) shape.kind = SHAPE_FACET;
  return shape;
}

Vector3 read_inertia(const JsonNode& node) {
  const Vector3 inertia = node.vector();
  for (const double moment : inertia) {
    if (!(moment > 0)) {
      node.fail(fmt::format("must be positive definite, has the principal moment {}", moment));
    }
  }
  for (unsigned i = 0; i < 3; ++i) {
    const double largest = inertia[i], others = inertia[(i + 1) % 3] + inertia[(i + 2) % 3];
    if (largest > others * (1 + 1e-9)) {
      node.fail(
          fmt::format("must keep the triangle inequality of real bodies, {} is more than {}, the sum of the others",
                      largest, others));
    }
  }
  return inertia;
}

void read_mass(const JsonNode& node, BodyDescription& body) {
  if (body.kind != BODY_DYNAMIC) {
    for (const char* key : {"mass", "density", "inertia"}) {
      if (node.has(key)) {
        node.at(key).fail(
            "belongs to a dynamic body; static and kinematic bodies act as if infinitely heavy; remove it");
      }
    }
    return;
  }
  if (node.has("mass") && node.has("density")) node.fail("has both \"mass\" and \"density\"; give one");
  if (!node.has("mass") && !node.has("density"))
    node.fail("needs \"mass\" or \"density\"; only static and kinematic bodies go without");
  const double density = node.has("density") ? node.at("density").positive() : 1;
  body.mass = node.has("mass") ? node.at("mass").positive() : 0;
  if (node.has("inertia")) {  // about the origin, which is the centre of mass, and along the axes of the file
    if (node.has("density")) node.at("density").fail("does not go with \"inertia\"; give \"mass\" instead");
    body.inertia = read_inertia(node.at("inertia"));
    return;
  }
  if (!has_solid_shapes(body)) node.fail("needs \"mass\" and \"inertia\"; they follow from shapes, and it has none");
  if (node.has("mass"))
    make_solid_of_mass(body, body.mass);
  else
    make_solid(body, density);
}

void read_motion(const JsonNode& node, BodyDescription& body) {
  if (body.kind == BODY_STATIC) {
    for (const char* key : {"velocity", "angular_velocity", "angular_velocity_body"}) {
      if (node.has(key)) node.at(key).fail("a static body does not move; make it kinematic or remove this");
    }
  }
  if (node.has("velocity")) {
    if (body.pivoted) node.at("velocity").fail("follows from the angular velocity of a body on a pivot; remove it");
    body.velocity = node.at("velocity").vector();
  }
  if (node.has("angular_velocity") && node.has("angular_velocity_body")) {
    node.fail("has both \"angular_velocity\" and \"angular_velocity_body\"; give one");
  }
  if (node.has("angular_velocity")) body.angular_velocity = node.at("angular_velocity").vector();
  if (node.has("angular_velocity_body")) {
    body.angular_velocity = exact::rotate(body.orientation, node.at("angular_velocity_body").vector());
  }
}

// A body that turns about a point fixed in the world: the pose is given by that point or by the centre of mass.
void read_pivot(const JsonNode& node, BodyDescription& body) {
  if (!node.has("com_offset")) {
    if (node.has("pivot")) node.fail("has a \"pivot\" and needs the key \"com_offset\"");
    return;
  }
  const JsonNode com_offset = node.at("com_offset");
  if (body.kind != BODY_DYNAMIC) com_offset.fail("belongs to a dynamic body; remove it");
  if (!body.shapes.empty()) com_offset.fail("a body on a pivot cannot have shapes; remove one of the two");
  body.pivoted = true;
  body.com_offset = com_offset.vector();
  const auto along = std::count_if(body.com_offset.begin(), body.com_offset.end(), [](double x) { return x != 0; });
  if (along != 1) {
    com_offset.fail(fmt::format("must lie along one principal axis (one component that is not 0), is [{}, {}, {}]",
                                body.com_offset[0], body.com_offset[1], body.com_offset[2]));
  }
  if (node.has("pivot")) {
    if (node.has("position")) node.fail("has both \"pivot\" and \"position\"; give one");
    body.position = exact::add(node.at("pivot").vector(), exact::rotate(body.orientation, body.com_offset));
  }
}

// The plane of a body that has three coordinates; "xyz" is any other body.
void read_plane(const JsonNode& node, BodyDescription& body) {
  const JsonNode dof = node.at("dof");
  body.plane_normal = dof.choice<Vector3>(
      "set of coordinates", {{"xyz", {0, 0, 0}}, {"xy", {0, 0, 1}}, {"yz", {1, 0, 0}}, {"xz", {0, 1, 0}}});
  if (body.plane_normal == Vector3{0, 0, 0}) return;
  if (body.kind != BODY_DYNAMIC) dof.fail("is for dynamic bodies: others move as they are told");
  if (body.pivoted) dof.fail("does not go with a pivot; add a hinge to \"world\" instead");
  const double across = exact::dot(body.plane_normal, body.velocity);
  const double other_axes = exact::length(exact::cross(body.plane_normal, body.angular_velocity));
  if (across != 0) dof.fail("leaves the body no velocity across its plane, and \"velocity\" has some");
  if (other_axes > 1e-9 * exact::length(body.angular_velocity))
    dof.fail("lets the body rotate about the normal of its plane alone, and its angular velocity has another axis");
}

}  // namespace

BodyDescription read_body(const JsonNode& node, Names& names) {
  node.expect_object({"name", "type", "mass", "density", "inertia", "position", "orientation", "velocity",
                      "angular_velocity", "angular_velocity_body", "pivot", "com_offset", "continuous", "dof",
                      "shapes"});
  BodyDescription body;
  if (node.has("name")) body.name = node.at("name").text();
  if (node.has("type")) {
    body.kind = node.at("type").choice<BodyKind>(
        "body type", {{"static", BODY_STATIC}, {"kinematic", BODY_KINEMATIC}, {"dynamic", BODY_DYNAMIC}});
  }
  if (node.has("shapes")) {
    for (const JsonNode& entry : node.at("shapes").elements())
      body.shapes.push_back(read_shape(entry, body.kind, names));
  }
  if (node.has("position")) body.position = node.at("position").vector();
  if (node.has("orientation")) body.orientation = read_orientation(node.at("orientation"));
  read_mass(node, body);
  read_pivot(node, body);
  read_motion(node, body);
  if (node.has("dof")) read_plane(node, body);
  if (node.has("continuous")) body.continuous = node.at("continuous").boolean();
  if (body.continuous && body.kind == BODY_STATIC)
    node.at("continuous").fail("a static body does not move; make the bodies that hit it continuous, or remove this");
  return body;
}

Categories::Categories(const std::vector<std::string>& names, const JsonNode& document) {
  for (const std::string& name : names) categories_.push_back({name, document, true});
}

std::vector<std::string> Categories::names() const {
  std::vector<std::string> names;
  for (const Category& category : categories_) names.push_back(category.name);
  return names;
}

Categories::Category& Categories::find(const JsonNode& name) {
  const std::string word = name.text();
  const auto found =
      std::find_if(categories_.begin(), categories_.end(), [&](const Category& c) { return c.name == word; });
  if (found != categories_.end()) return *found;
  // bit 0 is kept for "default", whether or not the file mentions it
  if (categories_.empty()) categories_.push_back({"default", name, true});
  if (word == "default") return categories_[0];
  if (categories_.size() == 32) name.fail("a scene can have 32 categories, \"default\" among them; this is one more");
  categories_.push_back({word, name, false});
  return categories_.back();
}

u32 Categories::own(const JsonNode& name) {
  Category& category = find(name);
  category.owned = true;
  return 1u << (&category - categories_.data());
}

u32 Categories::partner(const JsonNode& name) { return 1u << (&find(name) - categories_.data()); }

u32 Categories::add(const JsonNode& node, const std::string& name) {
  if (categories_.empty()) categories_.push_back({"default", node, true});
  if (categories_.size() == 32)
    node.fail("brings the scene to more than 32 categories, \"default\" among them; give the robot a \"category\"");
  categories_.push_back({name, node, true});
  return 1u << (categories_.size() - 1);
}

void Categories::expect_all_owned() const {
  std::vector<std::string> owned;
  for (const Category& category : categories_) {
    if (category.owned) owned.push_back(category.name);
  }
  for (const Category& category : categories_) {
    if (!category.owned) category.first.unknown("category", category.name, owned);
  }
}

u32 read_material(const JsonNode& name, const Names& names) {
  std::vector<std::string> known;
  for (const Material& material : names.materials) known.push_back(material.name);
  const auto found = std::find(known.begin(), known.end(), name.text());
  if (found == known.end()) name.unknown("material", name.text(), known);
  return static_cast<u32>(found - known.begin());
}

Vector3 read_direction(const JsonNode& node) {
  const Vector3 v = node.vector();
  if (v[0] == 0 && v[1] == 0 && v[2] == 0) node.fail("must not be zero: it is a direction");
  return v;
}

Quaternion read_orientation(const JsonNode& node) {
  if (node.is_array()) {
    const std::vector<JsonNode> components = node.elements();
    if (components.size() != 4) node.must_be("a quaternion [x, y, z, w]");
    const Quaternion q = {components[0].number(), components[1].number(), components[2].number(),
                          components[3].number()};
    const double length = exact::length(q);
    if (!(length > 1 - 1e-6 && length < 1 + 1e-6)) {
      node.fail(fmt::format("must be a unit quaternion within 1e-6, has the length {:.9g}", length));
    }
    return exact::unit(q);
  }
  node.expect_object({"axis", "angle", "angle_deg", "euler_deg"});
  const auto limited = [](const JsonNode& angle, double x, double limit) {
    if (x < -limit || x > limit) angle.fail(fmt::format("must be in -{0} .. {0}, is {1}", limit, x));
    return x;
  };
  if (node.has("euler_deg")) {
    for (const char* key : {"axis", "angle", "angle_deg"}) {
      if (node.has(key)) node.at(key).fail("does not go with \"euler_deg\"; remove one of the two");
    }
    const JsonNode angles = node.at("euler_deg");
    for (const double angle : angles.vector()) limited(angles, angle, most_degrees);
    return exact::rotation_from_euler_degrees(angles.vector());
  }
  const Vector3 axis = read_direction(node.at("axis"));
  if (node.has("angle") && node.has("angle_deg")) node.fail("has both \"angle\" and \"angle_deg\"; give one");
  if (node.has("angle_deg")) {
    const double half = 0.5 * limited(node.at("angle_deg"), node.at("angle_deg").number(), most_degrees);
    return exact::rotation(axis, exact::sine_of_degrees(half), exact::cosine_of_degrees(half));
  }
  if (!node.has("angle")) node.fail("needs \"angle\" (rad) or \"angle_deg\"");
  const double half = 0.5 * limited(node.at("angle"), node.at("angle").number(), exact::largest_angle);
  return exact::rotation(axis, exact::sine(half), exact::cosine(half));
}

void BodyCounts::add(const BodyDescription& body) {
  ++bodies;
  shapes += body.shapes.size();
  for (const ShapeDescription& shape : body.shapes)
    triangles += shape.kind == SHAPE_FACET ? simulated_shapes(shape) : 0;
}

void BodyList::expect_room(const JsonNode& entry, double copies, const BodyCounts& others) const {
  const auto all = [copies](std::size_t here, std::size_t more) {
    return static_cast<double>(here) + copies * static_cast<double>(more);
  };
  const double all_bodies = all(counts.bodies, others.bodies), all_shapes = all(counts.shapes, others.shapes),
               all_triangles = all(counts.triangles, others.triangles);
  if (std::max(all_bodies, all_shapes) > most_bodies)
    entry.fail(fmt::format(
        "would bring the scene to {:.0f} bodies and {:.0f} shapes, it can have {} of each; lower the counts",
        all_bodies, all_shapes, most_bodies));
  if (all_triangles > most_triangles)
    entry.fail(
        fmt::format("would bring the scene to {:.0f} triangles, its surfaces can have {}; make them fewer, or larger",
                    all_triangles, most_triangles));
}

void BodyList::add(BodyDescription body) {
  counts.add(body);
  bodies.push_back(std::move(body));
}

BodyList read_bodies(const JsonNode& array, Names& names) {
  BodyList list;
  for (const JsonNode& entry : array.elements()) {
    if (entry.is_object() && entry.has("generator")) {
      expand_generator(entry, names, list);
    } else {
      BodyDescription body = read_body(entry, names);
      BodyCounts one;
      one.add(body);
      list.expect_room(entry, 1, one);
      list.add(std::move(body));
    }
  }
  return list;
}

}  // namespace lockstep
