#include "host/scene/surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

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

Vector3 area_vector(const TriangleMesh& mesh, u32 t) {
  const auto& [a, b, c] = mesh.triangles[t];
  return cross(subtract(mesh.vertices[b], mesh.vertices[a]), subtract(mesh.vertices[c], mesh.vertices[a]));
}

class SurfaceMaker {
 public:
  explicit SurfaceMaker(TriangleMesh mesh) { surface_.mesh = std::move(mesh); }

  std::string run() {
    if (mesh().triangles.empty()) return "has no triangles; give a mesh that has";
    sort_corners();
    if (std::string flaw = flaw_of_edges(); !flaw.empty()) return flaw;
    if (std::string flaw = find_normals(); !flaw.empty()) return flaw;
    surface_.facets.resize(mesh().triangles.size());
    for (u32 t = 0; t < mesh().triangles.size(); ++t)
      for (u32 k = 0; k < 3; ++k) find_edge(t, k);
    for (u32 vertex = 0; vertex < mesh().vertices.size(); ++vertex) find_corners(vertex);
    return "";
  }

  Surface take() {
    surface_.edges.shrink_to_fit();
    return std::move(surface_);
  }

 private:
  // Corners of triangles are named as FACET_CORNER does.
  const TriangleMesh& mesh() const { return surface_.mesh; }
  u32 vertex_at(u32 corner) const { return mesh().triangles[corner >> 2][corner & 3]; }
  u32 vertex_after(u32 corner) const { return mesh().triangles[corner >> 2][((corner & 3) + 1) % 3]; }
  std::span<u32> around(u32 vertex) {
    return {at_vertex_.data() + first_[vertex], at_vertex_.data() + first_[vertex + 1]};
  }
  void sort_corners();
  std::string flaw_of_edges();
  std::string find_normals();
  u32 corner_beyond(u32 from, u32 to);
  void find_edge(u32 t, u32 k);
  void find_corners(u32 vertex);
  void link_fans(std::span<const u32> corners);
  u32 follower(u32 corner) const { return next_corner(surface_, corner >> 2, corner & 3); }
  void store_edge(u32 corner, const Vector3& across, u32 next);

  Surface surface_;
  std::vector<u32> first_, at_vertex_;  // the corners at each vertex, in order of the vertex that comes after
  std::vector<Vector3> normals_;
  std::vector<u32> corners_;  // of find_corners
};

void SurfaceMaker::sort_corners() {
  first_.assign(mesh().vertices.size() + 1, 0);
  for (const auto& triangle : mesh().triangles)
    for (const u32 vertex : triangle) ++first_[vertex + 1];
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  at_vertex_.resize(3 * mesh().triangles.size());
  std::vector<u32> slots(first_.begin(), first_.end() - 1);
  for (u32 t = 0; t < mesh().triangles.size(); ++t)
    for (u32 k = 0; k < 3; ++k) at_vertex_[slots[mesh().triangles[t][k]]++] = FACET_CORNER(t, k);
  for (u32 vertex = 0; vertex < mesh().vertices.size(); ++vertex)
    std::ranges::sort(around(vertex), {}, [&](u32 corner) { return std::pair(vertex_after(corner), corner); });
}

// Two triangles that run the same way along an edge: the first in the order of triangles and edges that is not alone.
std::string SurfaceMaker::flaw_of_edges() {
  u32 first = NONE, second = NONE;
  for (u32 vertex = 0; vertex < mesh().vertices.size(); ++vertex) {
    const std::span<const u32> corners = around(vertex);
    for (std::size_t i = 1; i < corners.size(); ++i) {
      const bool run_alike = vertex_after(corners[i - 1]) == vertex_after(corners[i]);
      const bool is_third = i > 1 && vertex_after(corners[i - 2]) == vertex_after(corners[i]);
      if (!run_alike || is_third || corners[i] >= second) continue;
      first = corners[i - 1];
      second = corners[i];
    }
  }
  return second == NONE ? "" : edge_run_twice(mesh(), first >> 2, second >> 2, vertex_at(second), vertex_after(second));
}

std::string SurfaceMaker::find_normals() {
  normals_.reserve(mesh().triangles.size());
  for (u32 t = 0; t < mesh().triangles.size(); ++t) {
    const auto& [a, b, c] = mesh().triangles[t];
    const Vector3 ab = subtract(mesh().vertices[b], mesh().vertices[a]),
                  ac = subtract(mesh().vertices[c], mesh().vertices[a]),
                  bc = subtract(mesh().vertices[c], mesh().vertices[b]), n = cross(ab, ac);
    const double longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
    if (!(dot(n, n) > least_height * least_height * longest * longest)) {
      return fmt::format("has a triangle without area, {} at {}; remove it", t, point_text(mesh().vertices[a]));
    }
    normals_.push_back(unit(n));
  }
  return "";
}

// The corner at `from` of the triangle on the other side of the edge from there to `to`; NONE where there is none.
u32 SurfaceMaker::corner_beyond(u32 from, u32 to) {
  const std::span<const u32> corners = around(to);
  const auto found = std::ranges::lower_bound(corners, from, {}, [&](u32 corner) { return vertex_after(corner); });
  if (found == corners.end() || vertex_after(*found) != from) return NONE;
  return FACET_CORNER(*found >> 2, ((*found & 3) + 1) % 3);
}

void SurfaceMaker::store_edge(u32 corner, const Vector3& across, u32 next) {
  FacetLinks& facet = surface_.facets[corner >> 2];
  const u32 k = corner & 3;
  facet.flags = (facet.flags & ~(3u << FACET_EDGE_SHIFT(k))) | FACET_EDGE_STORED << FACET_EDGE_SHIFT(k);
  facet.next[k] = static_cast<u32>(surface_.edges.size());
  surface_.edges.push_back({across, next});
}

void SurfaceMaker::find_edge(u32 t, u32 k) {
  const std::array<u32, 3>& triangle = mesh().triangles[t];
  const u32 from = triangle[k], to = triangle[(k + 1) % 3], beyond = corner_beyond(from, to);
  FacetLinks& facet = surface_.facets[t];
  if (beyond == NONE || t < beyond >> 2) facet.flags |= FACET_OWNS_EDGE(k);
  const bool folded =  // on itself: as at an end
      beyond != NONE && dot(normals_[beyond >> 2], normals_[t]) < least_bend * least_bend / 2 - 1;
  if (beyond == NONE || folded)
    return store_edge(FACET_CORNER(t, k), outward(mesh(), triangle, k, normals_[t]), beyond);
  const Vector3 along = unit(subtract(mesh().vertices[to], mesh().vertices[from]));
  const bool roof = dot(cross(normals_[t], normals_[beyond >> 2]), along) > least_bend;
  facet.next[k] = beyond;
  if (roof) facet.flags |= FACET_EDGE_ROOF << FACET_EDGE_SHIFT(k);
}

void SurfaceMaker::find_corners(u32 vertex) {
  const std::span<const u32> unordered = around(vertex);
  if (unordered.empty()) return;
  corners_.assign(unordered.begin(), unordered.end());
  std::ranges::sort(corners_);
  Vector3 sum = {0, 0, 0};
  std::size_t followed = 0;
  for (const u32 corner : corners_) {
    sum = add(sum, normals_[corner >> 2]);
    followed += follower(corner) != NONE;
  }
  const bool at_rim = followed < corners_.size();
  double lowest = 1, highest = -1;  // sines
  if (!at_rim && sum != Vector3{0, 0, 0}) {
    const Vector3 up = unit(sum);
    for (const u32 corner : corners_) {
      const double slope = dot(up, unit(subtract(mesh().vertices[vertex_after(corner)], mesh().vertices[vertex])));
      lowest = std::min(lowest, slope);
      highest = std::max(highest, slope);
    }
  }
  // at the rim, whatever is level or rises there, beyond it nothing is; else flat, or not the highest place
  if (!at_rim && (sum == Vector3{0, 0, 0} || lowest > -least_bend || highest > least_bend)) return;
  link_fans(corners_);
  for (const u32 corner : corners_)
    surface_.facets[corner >> 2].flags |= FACET_CORNER_COUNTS(corner & 3) | (at_rim ? FACET_IS_AT_RIM(corner & 3) : 0);
  // on a straight ridge the edges tell
  if (at_rim || highest < -least_bend)
    surface_.facets[corners_.front() >> 2].flags |= FACET_OWNS_CORNER(corners_.front() & 3);
}

// Makes one circle of the fans of triangles at a vertex: those that end at the rim, and several that meet there alone.
void SurfaceMaker::link_fans(std::span<const u32> corners) {
  std::size_t count = 1;
  u32 end = corners[0];
  for (; follower(end) != NONE && follower(end) != corners[0]; ++count) end = follower(end);
  if (count == corners.size() && follower(end) == corners[0]) return;
  std::vector<u32> starts, last;
  std::vector<bool> is_followed(corners.size()), is_seen(corners.size());
  const auto rank = [&](u32 corner) {
    return static_cast<std::size_t>(std::ranges::lower_bound(corners, corner) - corners.begin());
  };
  for (const u32 corner : corners)
    if (const u32 next = follower(corner); next != NONE) is_followed[rank(next)] = true;
  for (const bool open : {true, false}) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (is_seen[i] || (open && is_followed[i])) continue;
      starts.push_back(corners[i]);
      u32 at = corners[i];
      for (;;) {
        is_seen[rank(at)] = true;
        const u32 next = follower(at);
        if (next == NONE || next == corners[i]) break;
        at = next;
      }
      last.push_back(at);
    }
  }
  for (std::size_t fan = 0; fan < starts.size(); ++fan) {
    const u32 corner = last[fan], next = starts[(fan + 1) % starts.size()];
    if (follower(corner) == next) continue;
    FacetLinks& facet = surface_.facets[corner >> 2];
    if ((facet.flags >> FACET_EDGE_SHIFT(corner & 3) & 3) == FACET_EDGE_STORED)
      surface_.edges[facet.next[corner & 3]].next = next;
    else
      store_edge(corner, across_facet(surface_, corner >> 2, corner & 3), next);
  }
}

}  // namespace

std::string flaw_of_count(std::size_t triangles) {
  if (triangles <= most_triangles) return "";
  return fmt::format("has {} triangles, a surface can have {}; give it fewer, or larger ones", triangles,
                     most_triangles);
}

std::shared_ptr<const Surface> make_surface(TriangleMesh mesh, std::string& flaw) {
  flaw = flaw_of_count(mesh.triangles.size());
  if (!flaw.empty()) return nullptr;
  SurfaceMaker maker(welded(std::move(mesh)));
  flaw = maker.run();
  return flaw.empty() ? std::make_shared<const Surface>(maker.take()) : nullptr;
}

Vector3 normal_of_facet(const Surface& surface, u32 facet) { return unit(area_vector(surface.mesh, facet)); }

Vector3 across_facet(const Surface& surface, u32 facet, u32 k) {
  const FacetLinks& links = surface.facets[facet];
  switch (links.flags >> FACET_EDGE_SHIFT(k) & 3) {
    case FACET_EDGE_ROOF: return normal_of_facet(surface, links.next[k] >> 2);
    case FACET_EDGE_STORED: return surface.edges[links.next[k]].across;
    default: return normal_of_facet(surface, facet);
  }
}

u32 next_corner(const Surface& surface, u32 facet, u32 k) {
  const FacetLinks& links = surface.facets[facet];
  const bool stored = (links.flags >> FACET_EDGE_SHIFT(k) & 3) == FACET_EDGE_STORED;
  return stored ? surface.edges[links.next[k]].next : links.next[k];
}

Vector3 middle_of_facet(const Surface& surface, u32 facet) {
  const auto& [a, b, c] = surface.mesh.triangles[facet];
  return center_of_box(std::array{surface.mesh.vertices[a], surface.mesh.vertices[b], surface.mesh.vertices[c]});
}

std::array<Vector3, 3> corners_of_facet(const Surface& surface, u32 facet) {
  const Vector3 middle = middle_of_facet(surface, facet);
  std::array<Vector3, 3> corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = subtract(surface.mesh.vertices[surface.mesh.triangles[facet][k]], middle);
  return corners;
}

Vector3 offset_of_facet(const ShapeDescription& whole, u32 facet) {
  return add(whole.offset, exact::rotate(whole.rotation, middle_of_facet(*whole.surface, facet)));
}

std::size_t simulated_shapes(const ShapeDescription& shape) {
  return shape.kind == SHAPE_FACET ? shape.surface->facets.size() : 1;
}

std::size_t simulated_shapes(const BodyDescription& body) {
  std::size_t count = 0;
  for (const ShapeDescription& shape : body.shapes) count += simulated_shapes(shape);
  return count;
}

const ShapeDescription& description_of(const BodyDescription& body, u32 shape) {
  std::size_t past = 0;
  const auto found = std::ranges::find_if(body.shapes, [&](const ShapeDescription& description) {
    return (past += simulated_shapes(description)) > shape;
  });
  return *found;
}

std::size_t triangles_of_grid(std::size_t rows, std::size_t columns) { return 2 * (rows - 1) * (columns - 1); }

TriangleMesh height_field(const std::vector<std::vector<double>>& rows, double spacing) {
  const u32 along_x = static_cast<u32>(rows[0].size()), along_y = static_cast<u32>(rows.size());
  TriangleMesh mesh;
  mesh.vertices.reserve(rows.size() * rows[0].size());
  mesh.triangles.reserve(triangles_of_grid(rows.size(), rows[0].size()));
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
