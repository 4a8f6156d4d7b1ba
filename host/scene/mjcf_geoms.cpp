#include "host/scene/mjcf_geoms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>

#include "host/scene/hull.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/mesh.hpp"
#include "host/scene/robot_files.hpp"
#include "host/scene/surface.hpp"

namespace lockstep {

namespace {

namespace fs = std::filesystem;

Vector3 point_at(const std::vector<double>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

template <class Value>
const Value& find(const std::map<std::string, Value>& assets, const MjcfElement& geom, const char* kind) {
  const XmlNode& node = geom.holder(kind);
  const auto found = assets.find(node.text(kind));
  if (found != assets.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [other, value] : assets) known.push_back(other);
  node.unknown(kind, kind, std::move(known));
}

}  // namespace

MjcfGeoms::MjcfGeoms(const XmlNode& top, const MjcfCompiler& compiler, const MjcfDefaults& defaults)
    : compiler_(compiler) {
  for (const XmlNode& assets : top.children("asset")) {
    assets.expect_attributes({});
    assets.expect_children({"mesh", "hfield"}, {"texture", "material", "skin", "model"});
    for (const XmlNode& node : assets.children("mesh")) read_mesh_asset(defaults.element(node, 0, "mesh"));
    for (const XmlNode& node : assets.children("hfield")) {
      node.expect_attributes({"name", "file", "content_type", "nrow", "ncol", "size", "elevation"});
      if (!fields_.emplace(node.text("name"), node).second) node.fail("name", "is that of another height field");
    }
  }
}

void MjcfGeoms::read_mesh_asset(const MjcfElement& asset) {
  const XmlNode& node = asset.node();
  asset.expect_attributes({"name", "class", "file", "content_type", "vertex", "normal", "texcoord", "face", "scale",
                           "refpos", "refquat", "smoothnormal", "maxhullvert", "inertia", "material",
                           "octree_maxdepth"});
  Mesh mesh = {node, "", {}, asset.vector("scale", {1, 1, 1}), asset.vector("refpos", {0, 0, 0}), {0, 0, 0, 1}};
  for (const double s : mesh.scale)
    if (s == 0) asset.holder("scale").fail("scale", "must not be 0: the mesh would be flat");
  if (asset.has("refquat")) {
    mesh.orientation = quaternion_of(asset.holder("refquat"), "refquat");
  }
  std::string name;
  if (node.has("file")) {
    const std::string file = node.text("file");
    const fs::path path = (fs::path(node.source()).parent_path() / compiler_.mesh_folder / file).lexically_normal();
    std::error_code ignored;
    if (!is_embedded_mesh(path.string()) && !fs::is_regular_file(path, ignored))
      node.fail("file", fmt::format("names no file: {} does not exist; a mesh is looked for from the folder of the "
                                    "robot's file and the compiler's meshdir",
                                    quote(file)));
    mesh.path = path.string();
    name = fs::path(file).stem().string();
  } else if (node.has("vertex")) {
    mesh.points = node.numbers("vertex", 12, 3000000);
    if (mesh.points.size() % 3 != 0) node.fail("vertex", "must have three numbers for each point");
  } else {
    node.fail("needs the attribute \"file\", or \"vertex\"");
  }
  if (node.has("name")) name = node.text("name");
  if (name.empty()) node.fail("needs the attribute \"name\"");
  if (!meshes_.emplace(name, mesh).second)
    node.fail(fmt::format("is called {}, as another mesh is; names must differ", quote(name)));
}

TriangleMesh MjcfGeoms::mesh_of(const Mesh& mesh) const {
  TriangleMesh triangles;
  if (mesh.path.empty()) {
    for (std::size_t i = 0; i < mesh.points.size() / 3; ++i) triangles.vertices.push_back(point_at(mesh.points, i));
  } else {
    try {
      triangles = read_mesh(mesh.path);
    } catch (const std::runtime_error& error) {
      mesh.node.fail("file", fmt::format("cannot be read as a mesh: {}", error.what()));
    }
  }
  const Quaternion& q = mesh.orientation;
  const Quaternion back = {-q[0], -q[1], -q[2], q[3]};
  const Vector3& s = mesh.scale;
  for (Vector3& p : triangles.vertices)
    p = exact::rotate(back, exact::subtract({s[0] * p[0], s[1] * p[1], s[2] * p[2]}, mesh.position));
  if (s[0] * s[1] * s[2] < 0)
    for (std::array<u32, 3>& corners : triangles.triangles) std::swap(corners[1], corners[2]);
  return triangles;
}

// Its hull touches, and what it holds weighs: of a mesh that is closed, else of the hull. The mass is that of 1 kg/m^3.
MassProperties MjcfGeoms::set_mesh(const MjcfElement& geom, ShapeDescription& shape, bool weighs) const {
  const Mesh& mesh = find(meshes_, geom, "mesh");
  const TriangleMesh triangles = mesh_of(mesh);
  const ShapeDescription posed = shape;
  shape.kind = SHAPE_HULL;
  if (const std::string refusal = set_hull_of_many(triangles.vertices, shape); !refusal.empty())
    mesh.node.fail(mesh.path.empty() ? "vertex" : "file", refusal);
  if (!weighs) return {};
  const MassProperties hull = mass_properties(shape, 1);
  std::string flaw;
  if (triangles.triangles.empty() || !make_surface(triangles, flaw)) return hull;
  const VolumeMoments moments = volume_moments(triangles);
  if (!(moments.volume > 0) || moments.volume > hull.mass * 1.05) return hull;
  ShapeDescription solid = posed;
  solid.kind = SHAPE_MESH;
  solid.mesh = std::make_shared<const TriangleMesh>(triangles);
  return mass_properties(solid, 1);
}

void MjcfGeoms::set_size(const MjcfElement& geom, const std::string& type, ShapeDescription& shape) const {
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
    const Vector3 from = point_at(ends, 0), to = point_at(ends, 1), along = exact::subtract(from, to);
    half_length = 0.5 * exact::length(along);
    if (!(half_length > 0)) geom.holder("fromto").fail("fromto", "must be two points, they are one");
    shape.offset = exact::scale(0.5, exact::add(from, to));
    shape.rotation = exact::rotation_from_z_to(along);
  }
  if (type == "box") {
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

// Rows of the field go along y, and within them along x; lowest is 0, highest the third of the sizes.
ShapeDescription MjcfGeoms::field_of(const MjcfElement& geom, const ShapeDescription& whole) const {
  const XmlNode& node = find(fields_, geom, "hfield");
  if (!node.has("elevation")) node.fail("needs the attribute \"elevation\": pictures of heights are not read");
  const std::vector<double> size = node.numbers("size", 4, 4);
  for (const double s : size)
    if (!(s > 0)) node.fail("size", fmt::format("must be > 0, is {}", s));
  const double row_count = node.number("nrow"), column_count = node.number("ncol");
  for (const double count : {row_count, column_count})
    if (!(count >= 2 && count <= 2000) || count != std::floor(count))
      node.fail("must have \"nrow\" and \"ncol\" in 2 .. 2000");
  const auto rows = static_cast<std::size_t>(row_count), columns = static_cast<std::size_t>(column_count);
  const std::vector<double> heights = node.numbers("elevation", rows * columns, rows * columns);
  const auto [low, high] = std::ranges::minmax(heights);
  std::vector<std::vector<double>> grid(rows);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      const double height = heights[(rows - 1 - r) * columns + c];  // the first row of the file is farthest along y
      grid[r].push_back(high > low ? (height - low) / (high - low) * size[2] : 0);
    }
  }
  TriangleMesh mesh = height_field(grid, 1);
  for (Vector3& p : mesh.vertices) {
    p[0] *= 2 * size[0] / static_cast<double>(columns - 1);
    p[1] *= 2 * size[1] / static_cast<double>(rows - 1);
  }
  ShapeDescription field = whole;
  std::string flaw;
  field.kind = SHAPE_FACET;
  field.surface = make_surface(std::move(mesh), flaw);
  if (!field.surface) node.fail("elevation", flaw);
  return field;
}

u32 MjcfGeoms::surface_of(const MjcfElement& geom) {
  Surface surface;
  surface.condim = geom.number("condim", 3);
  surface.priority = geom.number("priority", 0);
  if (geom.has("friction")) {
    const std::vector<double> given = geom.holder("friction").numbers("friction", 1, 3);
    std::ranges::copy(given, surface.friction.begin());
    if (!std::ranges::all_of(given, [](double mu) { return mu >= 0; }))
      geom.holder("friction").fail("friction", "must be >= 0");
  }
  const auto found = std::ranges::find(surfaces_, surface);
  if (found != surfaces_.end()) return static_cast<u32>(found - surfaces_.begin());
  surfaces_.push_back(surface);
  return static_cast<u32>(surfaces_.size()) - 1;
}

u32 MjcfGeoms::filter_of(const MjcfElement& geom, bool& touches) {
  const auto bits = [&](const char* attribute) {
    const double value = geom.number(attribute, 1);
    if (!(value >= 0 && value <= 4294967295.0) || value != std::floor(value))
      geom.holder(attribute).fail(attribute, fmt::format("must be an integer of 32 bits, is {}", value));
    return static_cast<u32>(value);
  };
  const Filter filter = {bits("contype"), bits("conaffinity")};
  touches = filter.contype != 0 || filter.conaffinity != 0;
  if (!touches) return 0;
  const auto found = std::ranges::find(filters_, filter);
  if (found != filters_.end()) return static_cast<u32>(found - filters_.begin());
  if (filters_.size() == 32)
    geom.node().fail("is the 33rd pair of contype and conaffinity; a robot can have 32, (1, 1) among them");
  filters_.push_back(filter);
  return static_cast<u32>(filters_.size()) - 1;
}

MjcfGeom MjcfGeoms::read(const MjcfElement& geom, bool is_still, bool weighs) {
  const XmlNode& node = geom.node();
  geom.expect_attributes({"name",     "class",  "type",     "contype",  "conaffinity", "condim",    "group",
                          "priority", "size",   "material", "friction", "mass",        "density",   "shellinertia",
                          "solmix",   "solref", "solimp",   "margin",   "gap",         "fromto",    MJCF_POSE,
                          "hfield",   "mesh",   "fitscale", "rgba",     "fluidshape",  "fluidcoef", "user"});
  node.expect_children({});
  const std::string type = geom.text("type", "sphere");
  constexpr const char* types[] = {"plane", "hfield", "sphere", "capsule", "cylinder", "box", "mesh"};
  if (std::ranges::find(types, type) == std::end(types))
    geom.holder("type").fail(
        "type",
        fmt::format("{} is no shape here: plane, hfield, sphere, capsule, cylinder, box and mesh are; make it a "
                    "mesh, or one of these",
                    quote(type)));
  if (geom.has("mesh") && type != "mesh")
    geom.holder("mesh").fail("mesh", "is not fitted with other shapes; give the type mesh, or sizes");
  if (geom.choice("shellinertia").value_or(false)) geom.node().fail("shellinertia", "is not read; give an <inertial>");

  MjcfGeom out;
  ShapeDescription shape;
  shape.offset = geom.vector("pos", {0, 0, 0});
  shape.rotation = geom.orientation(compiler_);
  bool touches = false;
  const u32 filter = filter_of(geom, touches);
  shape.category = 1u << filter;
  if (touches) shape.material = surface_of(geom);
  if (type == "plane" || type == "hfield") {
    if (!is_still) node.fail(fmt::format("is a {}, which has no mass; its body must be fixed to the world", type));
    shape.kind = SHAPE_PLANE;
    if (touches) out.shapes = {type == "plane" ? shape : field_of(geom, shape)};
    return out;
  }
  if (type == "mesh") find(meshes_, geom, "mesh");
  const double density = geom.not_negative("density", 1000), given = geom.not_negative("mass", 0);
  weighs = weighs && (geom.has("mass") ? given : density) > 0;
  if (!touches && !weighs) return out;  // what is only looked at may have large meshes
  MassProperties solid;                 // of 1 kg/m^3
  if (type == "mesh") {
    solid = set_mesh(geom, shape, weighs);
  } else {
    set_size(geom, type, shape);
    if (weighs) solid = mass_properties(shape, 1);
  }
  if (weighs) {
    const double mass = geom.has("mass") ? given : solid.mass * density;
    out.solid = scaled(solid, mass / solid.mass);
  }
  if (touches) out.shapes.push_back(std::move(shape));
  return out;
}

RobotContacts MjcfGeoms::contacts(std::vector<RobotLink>& links) const {
  RobotContacts contacts;
  contacts.classes = static_cast<u32>(filters_.size());
  for (const Surface& surface : surfaces_) {
    Material material = {fmt::format("surface {}", contacts.materials.size()), surface.sliding(), 0};
    material.further = surface.further();
    contacts.materials.push_back(material);
  }
  if (contacts.materials.empty()) contacts.materials.push_back({"surface 0", 1, 0});
  for (u32 a = 0; a < surfaces_.size(); ++a) {
    for (u32 b = a + 1; b < surfaces_.size(); ++b) {
      const Surface &x = surfaces_[a], &y = surfaces_[b];
      const Surface& higher = x.priority > y.priority ? x : y;
      Surface both = higher;
      if (x.priority == y.priority) {
        for (std::size_t i = 0; i < both.friction.size(); ++i)
          both.friction[i] = std::max(x.friction[i], y.friction[i]);
        both.condim = std::max(x.condim, y.condim);
      }
      MaterialPairRule rule = {a, b, both.sliding(), 0};
      rule.further = both.further();
      contacts.pairs.push_back(rule);
    }
  }
  std::vector<u32> masks(filters_.size(), 0);
  for (u32 a = 0; a < filters_.size(); ++a) {
    for (u32 b = 0; b < filters_.size(); ++b) {
      const Filter &x = filters_[a], &y = filters_[b];
      if ((x.contype & y.conaffinity) != 0 || (y.contype & x.conaffinity) != 0) masks[a] |= 1u << b;
    }
  }
  for (RobotLink& link : links)
    for (ShapeDescription& shape : link.shapes) shape.mask = masks[static_cast<u32>(std::countr_zero(shape.category))];
  return contacts;
}

}  // namespace lockstep
