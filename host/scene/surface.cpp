#include "host/scene/surface.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/scene/hull.hpp"
#include "host/scene/triangle_mesh.hpp"

namespace lockstep {

namespace {

using exact::add, exact::cross, exact::dot, exact::scale, exact::subtract, exact::unit;

// Sines below which two facets are one plane, and a corner does not stick out.
constexpr double least_bend = 1e-3;
// The height of a triangle over its longest edge, below which it is a line.
constexpr double least_height = 1e-6;

// Across edge k of a triangle, out of it, in its plane.
Vector3 outward(const TriangleMesh& mesh, const std::array<u32, 3>& t, unsigned k, const Vector3& normal) {
  return unit(cross(subtract(mesh.vertices[t[(k + 1) % 3]], mesh.vertices[t[k]]), normal));
}

class SurfaceMaker {
 public:
  explicit SurfaceMaker(TriangleMesh mesh) { surface_.mesh = std::move(mesh); }

  std::string run() {
    if (mesh().triangles.empty()) return "has no triangles; give a mesh that has";
    std::string flaw;
    edges_ = triangles_at_edges(mesh(), flaw);
    if (flaw.empty()) flaw = find_normals();
    if (!flaw.empty()) return flaw;
    at_vertex_.resize(mesh().vertices.size());
    at_rim_.resize(mesh().vertices.size(), false);
    for (u32 t = 0; t < mesh().triangles.size(); ++t) {
      for (unsigned k = 0; k < 3; ++k) {
        const u32 vertex = mesh().triangles[t][k], next = mesh().triangles[t][(k + 1) % 3];
        at_vertex_[vertex].push_back(t);
        if (!edges_.contains({next, vertex})) at_rim_[vertex] = at_rim_[next] = true;
      }
    }
    for (u32 t = 0; t < mesh().triangles.size(); ++t) {
      for (unsigned k = 0; k < 3; ++k) {
        find_edge(t, k);
        find_corner(t, k);
      }
    }
    return "";
  }

  Surface take() { return std::move(surface_); }

 private:
  const TriangleMesh& mesh() const { return surface_.mesh; }
  std::string find_normals();
  void find_edge(u32 t, unsigned k);
  void find_corner(u32 t, unsigned k);

  Surface surface_;
  TrianglesAtEdges edges_;
  std::vector<std::vector<u32>> at_vertex_;
  std::vector<bool> at_rim_;
};

std::string SurfaceMaker::find_normals() {
  for (u32 t = 0; t < mesh().triangles.size(); ++t) {
    const auto& [a, b, c] = mesh().triangles[t];
    const Vector3 ab = subtract(mesh().vertices[b], mesh().vertices[a]),
                  ac = subtract(mesh().vertices[c], mesh().vertices[a]),
                  bc = subtract(mesh().vertices[c], mesh().vertices[b]), n = cross(ab, ac);
    const double longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
    if (!(dot(n, n) > least_height * least_height * longest * longest)) {
      return fmt::format("has a triangle without area, {} at {}; remove it", t, point_text(mesh().vertices[a]));
    }
    surface_.facets.push_back({unit(n), {}, {}, 0});
  }
  return "";
}

void SurfaceMaker::find_edge(u32 t, unsigned k) {
  const std::array<u32, 3>& triangle = mesh().triangles[t];
  const u32 from = triangle[k], to = triangle[(k + 1) % 3];
  Facet& facet = surface_.facets[t];
  const auto other = edges_.find({to, from});
  if (other == edges_.end() || t < other->second) facet.owned |= 1u << k;
  facet.across[k] = outward(mesh(), triangle, k, facet.normal);
  if (other == edges_.end()) return;
  const Vector3& normal = surface_.facets[other->second].normal;
  const bool folded = dot(normal, facet.normal) < least_bend * least_bend / 2 - 1;  // on itself: as at an end
  if (folded) return;
  const Vector3 along = unit(subtract(mesh().vertices[to], mesh().vertices[from]));
  const bool roof = dot(cross(facet.normal, normal), along) > least_bend;
  facet.across[k] = roof ? normal : facet.normal;
}

void SurfaceMaker::find_corner(u32 t, unsigned k) {
  const u32 vertex = mesh().triangles[t][k];
  std::vector<u32> around;
  Vector3 sum = {0, 0, 0};
  for (const u32 other : at_vertex_[vertex]) {
    sum = add(sum, surface_.facets[other].normal);
    for (const u32 v : mesh().triangles[other])
      if (v != vertex) around.push_back(v);
  }
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  if (at_rim_[vertex]) {  // whatever is level or rises there, beyond it nothing is
    Facet& facet = surface_.facets[t];
    facet.around[k] = std::move(around);
    facet.rim |= 1u << k;
    if (t == at_vertex_[vertex].front()) facet.owned |= 8u << k;
    return;
  }
  if (sum == Vector3{0, 0, 0}) return;
  const Vector3 up = unit(sum);
  double lowest = 1, highest = -1;  // sines
  for (const u32 v : around) {
    const double slope = dot(up, unit(subtract(mesh().vertices[v], mesh().vertices[vertex])));
    lowest = std::min(lowest, slope);
    highest = std::max(highest, slope);
  }
  if (lowest > -least_bend || highest > least_bend) return;  // flat, or not the highest place
  surface_.facets[t].around[k] = std::move(around);
  // on a straight ridge the edges tell
  if (highest < -least_bend && t == at_vertex_[vertex].front()) surface_.facets[t].owned |= 8u << k;
}

}  // namespace

std::shared_ptr<const Surface> make_surface(const TriangleMesh& mesh, std::string& flaw) {
  SurfaceMaker maker(welded(mesh));
  flaw = maker.run();
  return flaw.empty() ? std::make_shared<const Surface>(maker.take()) : nullptr;
}

Vector3 middle_of_facet(const Surface& surface, u32 facet) {
  const auto& [a, b, c] = surface.mesh.triangles[facet];
  return center_of_box({surface.mesh.vertices[a], surface.mesh.vertices[b], surface.mesh.vertices[c]});
}

std::vector<Vector3> corners_of_facet(const Surface& surface, u32 facet) {
  const Vector3 middle = middle_of_facet(surface, facet);
  std::vector<Vector3> corners;
  for (const u32 corner : surface.mesh.triangles[facet])
    corners.push_back(subtract(surface.mesh.vertices[corner], middle));
  return corners;
}

std::vector<ShapeDescription> facets_of(const ShapeDescription& whole) {
  std::vector<ShapeDescription> facets;
  for (u32 t = 0; t < whole.surface->facets.size(); ++t) {
    ShapeDescription facet = whole;
    facet.kind = SHAPE_FACET;
    facet.facet = t;
    facet.offset = add(whole.offset, exact::rotate(whole.rotation, middle_of_facet(*whole.surface, t)));
    facets.push_back(std::move(facet));
  }
  return facets;
}

TriangleMesh height_field(const std::vector<std::vector<double>>& rows, double spacing) {
  const u32 along_x = static_cast<u32>(rows[0].size()), along_y = static_cast<u32>(rows.size());
  TriangleMesh mesh;
  for (u32 j = 0; j < along_y; ++j) {
    for (u32 i = 0; i < along_x; ++i)
      mesh.vertices.push_back({(i - 0.5 * (along_x - 1)) * spacing, (j - 0.5 * (along_y - 1)) * spacing, rows[j][i]});
  }
  for (u32 j = 0; j + 1 < along_y; ++j) {
    for (u32 i = 0; i + 1 < along_x; ++i) {
      const u32 corner = j * along_x + i;
      mesh.triangles.push_back({corner, corner + 1, corner + along_x + 1});
      mesh.triangles.push_back({corner, corner + along_x + 1, corner + along_x});
    }
  }
  return mesh;
}

}  // namespace lockstep
