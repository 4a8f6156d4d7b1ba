#include "host/scene/mjcf_meshes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/scene/elevation_file.hpp"
#include "host/scene/hull.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/mesh.hpp"
#include "host/scene/mjcf_include.hpp"
#include "host/scene/robot_files.hpp"
#include "host/scene/surface.hpp"
#include "host/scene/triangle_moments.hpp"

namespace lockstep {

namespace {

namespace fs = std::filesystem;

template <class Value>
const Value& find(const std::map<std::string, Value>& assets, const MjcfElement& geom, const char* kind) {
  const XmlNode& node = geom.holder(kind);
  const auto found = assets.find(node.text(kind));
  if (found != assets.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [other, value] : assets) known.push_back(other);
  node.unknown(kind, kind, std::move(known));
}

MjcfMesh::Inertia inertia_of(const MjcfElement& asset) {
  constexpr const char* words[] = {"convex", "exact", "legacy", "shell"};
  const std::string word = asset.text("inertia", "legacy");
  const auto found = std::ranges::find(words, word);
  if (found == std::end(words))
    asset.holder("inertia").unknown("inertia", "inertia", {std::begin(words), std::end(words)});
  return static_cast<MjcfMesh::Inertia>(found - words);
}

}  // namespace

MjcfAssets::MjcfAssets(const XmlNode& top, const MjcfCompiler& compiler, const MjcfDefaults& defaults)
    : compiler_(compiler), main_(top.source()) {
  for (const XmlNode& assets : top.children("asset")) {
    for (const XmlNode& node : assets.children("mesh")) read_mesh(defaults.element(node, 0, {"mesh"}));
    for (const XmlNode& node : assets.children("hfield")) {
      const std::string name = node.has("name") ? node.text("name") : fs::path(node.text("file")).stem().string();
      if (!fields_.emplace(name, node).second) node.fail("name", "is that of another height field");
    }
  }
}

// Of built-in robots the path that their meshes are known by.
std::string MjcfAssets::file_of(const XmlNode& node) const {
  fs::path file = node.text("file");
  if (compiler_.strip_path) file = file.filename();
  const std::string said = (fs::path(compiler_.mesh_folder) / file).string();
  const std::string embedded = (fs::path(node.source()).parent_path() / said).lexically_normal().string();
  if (is_embedded_mesh(embedded)) return embedded;
  const fs::path path = file_beside(node, main_, said);
  if (path.empty())
    node.fail("file", fmt::format("names no file: {} does not exist; it is looked for from the folder of the robot's "
                                  "file and the compiler's meshdir",
                                  quote(node.text("file"))));
  return path.string();
}

void MjcfAssets::read_mesh(const MjcfElement& asset) {
  const XmlNode& node = asset.node();
  MjcfMesh mesh = {node,
                   "",
                   {},
                   {},
                   asset.vector("scale", {1, 1, 1}),
                   asset.vector("refpos", {0, 0, 0}),
                   {0, 0, 0, 1},
                   inertia_of(asset)};
  for (const double s : mesh.scale)
    if (s == 0) asset.holder("scale").fail("scale", "must not be 0: the mesh would be flat");
  if (asset.has("refquat")) mesh.orientation = quaternion_of(asset.holder("refquat"), "refquat");
  std::string name;
  if (node.has("file")) {
    mesh.path = file_of(node);
    name = fs::path(node.text("file")).stem().string();
  } else if (node.has("vertex")) {
    mesh.points = node.numbers("vertex", 12, 3000000);
    if (mesh.points.size() % 3 != 0) node.fail("vertex", "must have three numbers for each point");
    if (node.has("face")) mesh.faces = node.numbers("face", 3, 6000000);
    const double points = static_cast<double>(mesh.points.size() / 3);
    for (const double corner : mesh.faces)
      if (!(corner >= 0 && corner < points) || corner != std::floor(corner) || mesh.faces.size() % 3 != 0)
        node.fail("face", fmt::format("must be three of the {:g} points for each triangle, from 0 on", points));
  } else if (node.has("builtin")) {
    return;  // nothing that a geom finds
  } else {
    node.fail("needs the attribute \"file\", or \"vertex\"");
  }
  if (node.has("name")) name = node.text("name");
  if (name.empty()) node.fail("needs the attribute \"name\"");
  if (!meshes_.emplace(name, mesh).second)
    node.fail(fmt::format("is called {}, as another mesh is; names must differ", quote(name)));
}

const MjcfMesh& MjcfAssets::mesh(const MjcfElement& geom) const { return find(meshes_, geom, "mesh"); }

// The reference pose is of the mesh as its file has it; the scale comes last.
TriangleMesh MjcfMesh::triangles() const {
  TriangleMesh mesh;
  if (path.empty()) {
    for (std::size_t i = 0; i + 2 < points.size(); i += 3)
      mesh.vertices.push_back({points[i], points[i + 1], points[i + 2]});
    for (std::size_t i = 0; i + 2 < faces.size(); i += 3)
      mesh.triangles.push_back(
          {static_cast<u32>(faces[i]), static_cast<u32>(faces[i + 1]), static_cast<u32>(faces[i + 2])});
  } else {
    try {
      mesh = path.ends_with(".msh") ? read_msh(path) : read_mesh(path);
    } catch (const std::runtime_error& error) {
      node.fail("file", fmt::format("cannot be read as a mesh: {}", error.what()));
    }
  }
  const Quaternion back = {-orientation[0], -orientation[1], -orientation[2], orientation[3]};
  for (Vector3& p : mesh.vertices) {
    p = exact::rotate(back, exact::subtract(p, position));
    p = {scale[0] * p[0], scale[1] * p[1], scale[2] * p[2]};
  }
  if (scale[0] * scale[1] * scale[2] < 0)
    for (std::array<u32, 3>& corners : mesh.triangles) std::swap(corners[1], corners[2]);
  return mesh;
}

void MjcfMesh::set_hull(ShapeDescription& shape) const {
  shape.kind = SHAPE_HULL;
  if (const std::string refusal = set_hull_of_many(triangles().vertices, shape); !refusal.empty())
    node.fail(path.empty() ? "vertex" : "file", refusal);
}

MassProperties MjcfMesh::solid() const {
  TriangleMesh mesh = triangles();
  if (mesh.triangles.empty() || inertia == Inertia::convex) mesh = hull_triangles(mesh.vertices);
  const MassProperties solid =
      inertia == Inertia::shell ? shell_moments(mesh) : solid_moments(mesh, inertia == Inertia::legacy);
  if (!(solid.mass > 0))
    node.fail(fmt::format("has no {}; give the body an <inertial>", inertia == Inertia::shell ? "area" : "volume"));
  return solid;
}

// Rows of the field go along y, and within them along x; lowest is 0, highest the third of the sizes.
void MjcfAssets::set_field(const MjcfElement& geom, ShapeDescription& shape) const {
  const XmlNode& node = find(fields_, geom, "hfield");
  const std::vector<double> size = node.numbers("size", 4, 4);
  for (const double s : size)
    if (!(s > 0)) node.fail("size", fmt::format("must be > 0, is {}", s));
  Elevations field;
  if (node.has("file")) {
    try {
      field = read_elevations(file_of(node));
    } catch (const std::runtime_error& error) {
      node.fail("file", fmt::format("cannot be read as a height field: {}", error.what()));
    }
  } else {
    const double row_count = node.number("nrow"), column_count = node.number("ncol");
    for (const double count : {row_count, column_count})
      if (!(count >= 2 && count <= 2000) || count != std::floor(count))
        node.fail("must have \"nrow\" and \"ncol\" in 2 .. 2000");
    field.rows = static_cast<std::size_t>(row_count), field.columns = static_cast<std::size_t>(column_count);
    const std::size_t count = field.rows * field.columns;  // flat where nothing is said
    const std::vector<double> heights =
        node.has("elevation") ? node.numbers("elevation", count, count) : std::vector<double>(count, 0);
    for (std::size_t r = field.rows; r-- > 0;)  // the first row of the file is farthest along y
      field.heights.insert(field.heights.end(), heights.begin() + static_cast<std::ptrdiff_t>(r * field.columns),
                           heights.begin() + static_cast<std::ptrdiff_t>((r + 1) * field.columns));
  }
  if (field.rows < 2 || field.columns < 2 || field.rows > 2000 || field.columns > 2000)
    node.fail("must have 2 .. 2000 rows and columns");
  const auto [low, high] = std::ranges::minmax(field.heights);
  std::vector<std::vector<double>> grid(field.rows);
  for (std::size_t r = 0; r < field.rows; ++r)
    for (std::size_t c = 0; c < field.columns; ++c)
      grid[r].push_back(high > low ? (field.heights[r * field.columns + c] - low) / (high - low) * size[2] : 0);
  TriangleMesh mesh = height_field(grid, 1);
  for (Vector3& p : mesh.vertices) {
    p[0] *= 2 * size[0] / static_cast<double>(field.columns - 1);
    p[1] *= 2 * size[1] / static_cast<double>(field.rows - 1);
  }
  std::string flaw;
  shape.kind = SHAPE_FACET;
  shape.surface = make_surface(std::move(mesh), flaw);
  if (!shape.surface) node.fail(node.has("file") ? "file" : "elevation", flaw);
}

}  // namespace lockstep
