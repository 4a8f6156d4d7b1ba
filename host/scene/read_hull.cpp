#include "host/scene/read_hull.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "host/scene/hull.hpp"
#include "host/scene/mesh.hpp"
#include "host/scene/surface.hpp"
#include "host/scene/triangle_mesh.hpp"

namespace lockstep {

namespace {

std::vector<Vector3> read_points(const JsonNode& array) {
  std::vector<Vector3> points;
  for (const JsonNode& point : array.elements()) points.push_back(point.vector());
  return points;
}

std::filesystem::path mesh_path(const JsonNode& name) {
  return std::filesystem::path(name.source()).parent_path() / name.text();
}

TriangleMesh read_mesh_file(const JsonNode& name, double scale) {
  const std::filesystem::path path = mesh_path(name);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    name.fail(fmt::format("names the directory {}; give a mesh file in it", path.string()));
  if (!is_embedded_mesh(path.string()) && !std::filesystem::exists(path, ignored))
    name.fail(fmt::format("names no file: {} does not exist; a mesh is looked for from the folder of the scene",
                          path.string()));
  try {
    TriangleMesh mesh = read_mesh(path.string());
    for (Vector3& p : mesh.vertices) p = exact::scale(scale, p);
    return mesh;
  } catch (const std::runtime_error& error) {
    name.fail(fmt::format("cannot be read as a mesh: {}", error.what()));
  }
}

TriangleMesh read_finite_mesh(const JsonNode& node) {
  const double scale = node.has("scale") ? node.at("scale").positive() : 1;
  TriangleMesh mesh = read_mesh_file(node.at("mesh"), scale);
  for (const Vector3& v : mesh.vertices) {
    for (const double x : v)
      if (!(std::abs(x) < 1e15))
        node.at("mesh").fail(fmt::format("must be finite and below 1e15 m, has the coordinate {}", x));
  }
  return mesh;
}

}  // namespace

void read_hull(const JsonNode& node, ShapeDescription& shape) {
  if (node.has("points") == node.has("mesh")) node.fail("needs one of the keys \"points\" and \"mesh\"");
  if (node.has("points") && node.has("scale")) node.at("scale").fail("belongs to a mesh; scale the points instead");
  const JsonNode source = node.at(node.has("points") ? "points" : "mesh");
  const double scale = node.has("scale") ? node.at("scale").positive() : 1;
  const std::vector<Vector3> given = node.has("points") ? read_points(source) : read_mesh_file(source, scale).vertices;
  if (const std::string refusal = set_hull(given, shape); !refusal.empty()) source.fail(refusal);
}

void read_solid_mesh(const JsonNode& node, ShapeDescription& shape) {
  const TriangleMesh mesh = welded(read_finite_mesh(node));
  if (const std::string flaw = flaw_of(mesh); !flaw.empty()) node.at("mesh").fail(flaw);
  shape.mesh = std::make_shared<const TriangleMesh>(mesh);
}

void read_surface(const JsonNode& node, ShapeDescription& shape) {
  std::string flaw = flaw_of_count(triangles_announced(mesh_path(node.at("mesh")).string()));
  if (!flaw.empty()) node.at("mesh").fail(flaw);
  shape.surface = make_surface(read_finite_mesh(node), flaw);
  if (!flaw.empty()) node.at("mesh").fail(flaw);
}

void read_height_field(const JsonNode& node, ShapeDescription& shape) {
  const double spacing = node.at("spacing").positive();
  const std::vector<JsonNode> rows = node.at("heights").elements();
  if (rows.size() < 2) node.at("heights").must_be("at least two rows of numbers");
  const std::size_t length = rows.front().elements().size();
  if (length < 2) rows.front().must_be("at least two numbers");
  std::string flaw = flaw_of_count(triangles_of_grid(rows.size(), length));
  if (!flaw.empty()) node.at("heights").fail(flaw);
  std::vector<std::vector<double>> heights;
  for (const JsonNode& row : rows) {
    heights.emplace_back();
    for (const JsonNode& height : row.elements()) heights.back().push_back(height.number());
    if (heights.back().size() != length)
      row.fail(
          fmt::format("has {} heights, and the first row {}; give all rows as many", heights.back().size(), length));
  }
  shape.surface = make_surface(height_field(heights, spacing), flaw);
  if (!flaw.empty()) node.at("heights").fail(flaw);
}

}  // namespace lockstep
