#include "host/scene/urdf_links.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/scene/json_node.hpp"
#include "host/scene/mesh.hpp"
#include "host/scene/package_files.hpp"
#include "host/scene/real_inertia.hpp"
#include "host/scene/robot_files.hpp"

namespace lockstep {

// Names come from the file: keep a line a line.
static std::string in_one_line(const std::string& name) {
  const std::string quoted = quote(name);
  return quoted.substr(1, quoted.size() - 2);
}

void UrdfReading::leave_out_others(const XmlNode& node, std::initializer_list<std::string_view> attributes,
                                   std::initializer_list<std::string_view> children) {
  const auto is_among = [](const std::string& word, std::initializer_list<std::string_view> words) {
    return std::ranges::find(words, word) != words.end();
  };
  for (const std::string& attribute : node.attributes())
    if (!is_among(attribute, attributes) && !attribute.starts_with("xmlns"))
      left_out.add(node.location(), node.name() + " " + in_one_line(attribute));
  for (const XmlNode& child : node.children()) {
    const std::string name = child.name();
    if (name.starts_with("xacro:")) child.fail("is to be expanded first: xacro x.urdf.xacro > x.urdf");
    if (!is_among(name, children)) left_out.add(child.location(), in_one_line(name));
  }
}

void read_urdf_origin(const XmlNode& node, UrdfReading& reading, Vector3& position, Quaternion& orientation) {
  const std::optional<XmlNode> origin = node.child("origin");
  if (!origin) return;
  reading.leave_out_others(*origin, {"xyz", "rpy"});
  if (origin->has("xyz")) position = origin->vector("xyz");
  if (!origin->has("rpy")) return;
  const Vector3 angles = origin->vector("rpy");  // about the fixed axes x, then y, then z
  for (unsigned axis = 0; axis < 3; ++axis) {
    const double angle = angles[axis];
    if (std::abs(angle) > exact::largest_angle)
      origin->fail("rpy", fmt::format("must be in -{0} .. {0} rad, is {1}", exact::largest_angle, angle));
    if (angle == 0) continue;
    Vector3 direction = {0, 0, 0};
    direction[axis] = 1;
    const Quaternion rotation = exact::rotation(direction, exact::sine(0.5 * angle), exact::cosine(0.5 * angle));
    orientation = exact::unit(exact::multiply(rotation, orientation));
  }
}

namespace {

// Nothing where the mass is 0, as many files have it for what is a frame alone.
std::optional<MassProperties> read_inertial(const XmlNode& node, const std::string& link, UrdfReading& reading) {
  reading.leave_out_others(node, {}, {"origin", "mass", "inertia"});
  Vector3 position = {0, 0, 0};
  Quaternion orientation = {0, 0, 0, 1};
  read_urdf_origin(node, reading, position, orientation);
  const XmlNode mass = node.needed_child("mass"), inertia = node.needed_child("inertia");
  reading.leave_out_others(mass, {"value"});
  reading.leave_out_others(inertia, {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"});
  if (mass.not_negative("value") == 0) return std::nullopt;
  const auto product = [&](const char* name) { return inertia.has(name) ? inertia.number(name) : 0; };
  MassProperties own;
  own.mass = mass.number("value");
  own.inertia = {inertia.number("ixx"), inertia.number("iyy"), inertia.number("izz"),
                 product("ixy"),        product("ixz"),        product("iyz")};
  MassProperties solid = transformed(own, position, orientation);
  if (is_real(solid)) return solid;
  reading.mended.push_back(quote(link));
  return nearest_real(solid);
}

void read_mesh_hull(const XmlNode& node, UrdfReading& reading, ShapeDescription& shape) {
  reading.leave_out_others(node, {"filename", "scale"});
  const Vector3 scale = node.has("scale") ? node.vector("scale") : Vector3{1, 1, 1};
  for (const double s : scale)
    if (s == 0) node.fail("scale", "must not be 0: the mesh would be flat");
  const std::string path = robot_file_path(node, "filename", reading.robots.packages);
  std::vector<Vector3> points;
  try {
    points = read_mesh(path).vertices;
  } catch (const std::runtime_error& error) {
    node.fail("filename", fmt::format("cannot be read as a mesh: {}", error.what()));
  }
  for (Vector3& p : points) p = {scale[0] * p[0], scale[1] * p[1], scale[2] * p[2]};
  shape.kind = SHAPE_HULL;
  if (const std::string refusal = set_hull_of_many(points, shape); !refusal.empty()) node.fail("filename", refusal);
}

ShapeDescription read_collision(const XmlNode& node, UrdfReading& reading) {
  reading.leave_out_others(node, {"name"}, {"origin", "geometry"});
  ShapeDescription shape;
  read_urdf_origin(node, reading, shape.offset, shape.rotation);
  const XmlNode geometry = node.needed_child("geometry");
  reading.leave_out_others(geometry, {}, {"box", "cylinder", "sphere", "capsule", "mesh"});
  std::vector<XmlNode> forms;
  for (const char* form : {"box", "cylinder", "sphere", "capsule", "mesh"})
    for (const XmlNode& found : geometry.children(form)) forms.push_back(found);
  if (forms.size() != 1)
    geometry.fail(fmt::format("must hold one box, cylinder, sphere, capsule or mesh, has {}; give each a <collision>",
                              forms.size()));
  const XmlNode& form = forms[0];
  if (form.name() == "mesh") {
    read_mesh_hull(form, reading, shape);
    return shape;
  }
  if (form.name() == "box") {
    reading.leave_out_others(form, {"size"});
    shape.kind = SHAPE_BOX;
    const Vector3 size = form.vector("size");
    for (unsigned i = 0; i < 3; ++i) {
      if (!(size[i] > 0)) form.fail("size", fmt::format("must be > 0 along each axis, is {}", size[i]));
      shape.half_extents[i] = 0.5 * size[i];
    }
    return shape;
  }
  shape.kind = form.name() == "sphere" ? SHAPE_SPHERE : form.name() == "capsule" ? SHAPE_CAPSULE : SHAPE_CYLINDER;
  shape.radius = form.positive("radius");
  if (shape.kind == SHAPE_SPHERE) {
    reading.leave_out_others(form, {"radius"});
    shape.rotation = {0, 0, 0, 1};
  } else {
    reading.leave_out_others(form, {"radius", "length"});
    shape.half_length = 0.5 * form.positive("length");
  }
  return shape;
}

}  // namespace

RobotLink read_urdf_link(const XmlNode& node, UrdfReading& reading) {
  reading.leave_out_others(node, {"name"}, {"inertial", "collision", "visual"});
  RobotLink link;
  link.name = node.text("name");
  link.location = fmt::format("{} {}", node.location(), quote(link.name));
  if (const std::optional<XmlNode> inertial = node.child("inertial"))
    link.inertial = read_inertial(*inertial, link.name, reading);
  for (const XmlNode& collision : node.children("collision")) link.shapes.push_back(read_collision(collision, reading));
  return link;
}

}  // namespace lockstep
