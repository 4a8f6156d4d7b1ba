#include "host/scene/mjcf_geoms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host/scene/hull.hpp"
#include "host/scene/json_node.hpp"

namespace lockstep {

namespace {

// Of an ellipsoid: two poles and rings between them, as many as a hull may have.
std::vector<Vector3> points_of_ellipsoid(const Vector3& half) {
  constexpr u32 rings = 7, meridians = 18;
  static_assert(rings * meridians + 2 == most_hull_vertices);
  std::vector<Vector3> points = {{0, 0, half[2]}, {0, 0, -half[2]}};
  for (u32 ring = 1; ring <= rings; ++ring) {
    const double latitude = 180.0 * ring / (rings + 1);
    for (u32 k = 0; k < meridians; ++k) {
      const double longitude = 360.0 * k / meridians, radius = exact::sine_of_degrees(latitude);
      points.push_back({half[0] * radius * exact::cosine_of_degrees(longitude),
                        half[1] * radius * exact::sine_of_degrees(longitude),
                        half[2] * exact::cosine_of_degrees(latitude)});
    }
  }
  return points;
}

}  // namespace

void MjcfGeoms::set_size(const MjcfElement& geom, const std::string& type, ShapeDescription& shape) const {
  if (geom.has("mesh")) return fit(geom, type, shape);
  const bool is_long = type == "capsule" || type == "cylinder";
  const bool by_ends = geom.has("fromto");
  if (by_ends && type == "sphere")
    geom.holder("fromto").fail("fromto", "is of capsules, cylinders and boxes; leave it out, and give pos");
  const std::size_t needed = type == "sphere" || by_ends ? 1 : is_long ? 2 : 3;
  const XmlNode& holder = geom.holder("size");
  if (!holder.has("size")) holder.fail("needs the attribute \"size\"");
  const std::vector<double> size = holder.numbers("size", needed, 3);
  for (std::size_t i = 0; i < needed; ++i)
    if (!(size[i] > 0)) holder.fail("size", fmt::format("must be > 0, is {}", size[i]));
  double half_length = is_long && !by_ends ? size[1] : 0;
  if (by_ends) {
    const std::vector<double> ends = geom.holder("fromto").numbers("fromto", 6, 6);
    const Vector3 from = {ends[0], ends[1], ends[2]}, to = {ends[3], ends[4], ends[5]},
                  along = exact::subtract(from, to);
    half_length = 0.5 * exact::length(along);
    if (!(half_length > 0)) geom.holder("fromto").fail("fromto", "must be two points, they are one");
    shape.offset = exact::scale(0.5, exact::add(from, to));
    shape.rotation = exact::rotation_from_z_to(along);
  }
  if (type == "box" || type == "ellipsoid") {
    shape.kind = SHAPE_BOX;
    if (by_ends)
      shape.half_extents = {size[0], size[0], half_length};  // a second size is not looked at
    else
      shape.half_extents = {size[0], size[1], size[2]};
    return;
  }
  shape.kind = type == "sphere" ? SHAPE_SPHERE : type == "capsule" ? SHAPE_CAPSULE : SHAPE_CYLINDER;
  shape.radius = size[0];
  if (is_long)
    shape.half_length = half_length;
  else
    shape.rotation = {0, 0, 0, 1};
}

// Half sizes of the box that has the moments of a mesh, the longest along z, and its shape by that.
void MjcfGeoms::fit(const MjcfElement& geom, const std::string& type, ShapeDescription& shape) const {
  const MassProperties solid = assets_.mesh(geom).solid();
  const PrincipalAxes axes = principal_axes(solid.inertia);
  std::array<unsigned, 3> order = {0, 1, 2};
  std::ranges::stable_sort(order, [&](unsigned a, unsigned b) { return axes.moments[a] > axes.moments[b]; });
  const double scale = geom.number("fitscale", 1);
  Vector3 half;
  for (unsigned i = 0; i < 3; ++i) {
    const double others = axes.moments[order[(i + 1) % 3]] + axes.moments[order[(i + 2) % 3]];
    half[i] = 0.5 * exact::square_root(std::max(0.0, 6 * (others - axes.moments[order[i]]) / solid.mass));
  }
  std::array<Vector3, 3> unit = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const Quaternion rotated = exact::rotation_to_frame(exact::rotate(axes.rotation, unit[order[2]]),
                                                      exact::rotate(axes.rotation, unit[order[0]]));
  shape.offset = exact::add(shape.offset, exact::rotate(shape.rotation, solid.center));
  shape.rotation = exact::unit(exact::multiply(shape.rotation, rotated));
  if (type == "box" || type == "ellipsoid") {
    shape.kind = SHAPE_BOX;
    shape.half_extents = exact::scale(scale, half);
    return;
  }
  shape.kind = type == "sphere" ? SHAPE_SPHERE : type == "capsule" ? SHAPE_CAPSULE : SHAPE_CYLINDER;
  shape.radius = type == "sphere" ? (half[0] + half[1] + half[2]) / 3 : 0.5 * (half[0] + half[1]);
  shape.half_length = type == "capsule" ? std::max(0.0, half[2] - 0.5 * shape.radius) : half[2];
  shape.radius *= scale;
  shape.half_length *= scale;
  if (type == "sphere") shape.rotation = {0, 0, 0, 1};
}

// The box that holds it becomes the hull of points on it; the mass that of 1 kg/m^3 of the ellipsoid itself.
MassProperties MjcfGeoms::set_ellipsoid(const MjcfElement& geom, ShapeDescription& shape) {
  const Vector3 h = shape.half_extents;
  MassProperties solid;
  solid.mass = 4.0 / 3.0 * exact::pi * h[0] * h[1] * h[2];
  for (unsigned i = 0; i < 3; ++i) {
    const double a = h[(i + 1) % 3], b = h[(i + 2) % 3];
    solid.inertia[i] = 0.2 * solid.mass * (a * a + b * b);
  }
  solid = transformed(solid, shape.offset, shape.rotation);
  if (h[0] == h[1] && h[1] == h[2]) {
    shape.kind = SHAPE_SPHERE;
    shape.radius = h[0];
    shape.rotation = {0, 0, 0, 1};
    return solid;
  }
  left_out_.replace("ellipsoid", fmt::format("a hull of {} corners", most_hull_vertices));
  if (const std::string refusal = set_hull(points_of_ellipsoid(h), shape); !refusal.empty())
    geom.holder("size").fail("size", refusal);
  shape.kind = SHAPE_HULL;
  return solid;
}

MjcfGeom MjcfGeoms::read(const MjcfElement& geom, bool is_still, bool weighs) {
  const XmlNode& node = geom.node();
  std::string type = geom.text("type", "sphere");
  constexpr const char* types[] = {"plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"};
  MjcfGeom out;
  if (type == "sdf") {
    left_out_.approximate(node.location(), "is a distance function of a plugin, which is not simulated", "geom sdf");
    if (!geom.has("mesh")) return out;
    type = "mesh";
  }
  if (std::ranges::find(types, type) == std::end(types))
    geom.holder("type").unknown("type", "shape", {std::begin(types), std::end(types)});

  ShapeDescription shape;
  shape.offset = geom.vector("pos", {0, 0, 0});
  shape.rotation = geom.orientation(compiler_);
  const bool touches = contacts_.set(geom, shape);
  if (type == "plane" || type == "hfield") {
    if (!is_still) node.fail(fmt::format("is a {}, which has no mass; its body must be fixed to the world", type));
    shape.kind = SHAPE_PLANE;
    if (touches && type == "hfield") assets_.set_field(geom, shape);
    if (touches) out.shape = shape;
    return out;
  }
  const double group = geom.number("group", 0);
  const double density = geom.not_negative("density", 1000), given = geom.not_negative("mass", 0);
  weighs = weighs && (geom.has("mass") ? given : density) > 0 && group >= compiler_.first_group &&
           group <= compiler_.last_group;
  if (!touches && !weighs) return out;  // what is only looked at may have large meshes
  if (weighs && geom.choice("shellinertia").value_or(false) && type != "mesh")
    left_out_.approximate(node.location(), "shellinertia is of meshes here; give an <inertial>", "geom shellinertia");
  MassProperties solid;  // of 1 kg/m^3
  if (type == "mesh") {
    const MjcfMesh& mesh = assets_.mesh(geom);
    const RobotPose pose = {shape.offset, shape.rotation};
    if (touches) mesh.set_hull(shape);
    if (weighs) solid = transformed(mesh.solid(), pose.position, pose.orientation);
  } else {
    set_size(geom, type, shape);
    if (type == "ellipsoid")
      solid = set_ellipsoid(geom, shape);
    else if (weighs)
      solid = mass_properties(shape, 1);
  }
  if (weighs) {
    const double mass = geom.has("mass") ? given : solid.mass * density;
    out.solid = scaled(solid, mass / solid.mass);
  }
  if (touches) out.shape = std::move(shape);
  return out;
}

}  // namespace lockstep
