#include "host/scene/hull.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "host/scene/facets.hpp"
#include "host/scene/surface.hpp"

namespace lockstep {

namespace {

using exact::cross;
using exact::dot;
using exact::subtract;

// The point that is farthest by some measure, the first of equals.
template <class Measure>
std::pair<std::size_t, double> farthest(const std::vector<Vector3>& points, Measure&& measure) {
  std::pair<std::size_t, double> best = {0, -1};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = measure(points[i]);
    if (x > best.second) best = {i, x};
  }
  return best;
}

// Points that are flatter than this, relative to their length, have no inside: ten times `coplanar`.
constexpr double thinnest = 1e-5;

// Why points have no hull, if so.
std::string refuse(const std::vector<Vector3>& points) {
  if (points.size() < 4)
    return fmt::format("a hull needs at least 4 points that differ and are not in one plane, has {}; add some",
                       points.size());
  const auto [end, length] = farthest(points, [&](const Vector3& p) { return exact::length(subtract(p, points[0])); });
  const Vector3 along = exact::unit(subtract(points[end], points[0]));
  const auto [side, width] =
      farthest(points, [&](const Vector3& p) { return exact::length(cross(along, subtract(p, points[0]))); });
  if (width <= thinnest * length) return "its points lie on a line; move some of them apart";
  const Vector3 normal = exact::unit(cross(along, subtract(points[side], points[0])));
  const double height =
      farthest(points, [&](const Vector3& p) { return std::abs(dot(normal, subtract(p, points[0]))); }).second;
  if (height <= thinnest * length) return "its points lie in a plane; give it a thickness, or use a box";
  return "";
}

// Twice the area of a face times its normal (Newell): all corners count, whatever rounding did to one of them.
Vector3 area_normal(const std::vector<Vector3>& vertices, const std::vector<u32>& face) {
  Vector3 sum = {0, 0, 0};
  for (std::size_t i = 1; i + 1 < face.size(); ++i) {
    sum = exact::add(
        sum, cross(subtract(vertices[face[i]], vertices[face[0]]), subtract(vertices[face[i + 1]], vertices[face[0]])));
  }
  return sum;
}

using Triangle = std::array<u32, 3>;
using DirectedEdge = std::pair<u32, u32>;

// Which of the outward triangles stands left of each directed edge; nothing where the surface is not closed.
std::optional<std::map<DirectedEdge, u32>> neighbours(const std::vector<Triangle>& triangles) {
  std::map<DirectedEdge, u32> left;
  for (u32 t = 0; t < triangles.size(); ++t)
    for (unsigned k = 0; k < 3; ++k)
      if (!left.emplace(DirectedEdge{triangles[t][k], triangles[t][(k + 1) % 3]}, t).second) return std::nullopt;
  for (const auto& [edge, triangle] : left)
    if (!left.contains({edge.second, edge.first})) return std::nullopt;
  return left;
}

// Triangles that share a plane, by the name of one of them: neighbours join the group of the largest one beside them,
// so that no plane is tilted by a chain of small steps.
std::vector<u32> group_coplanar(const std::vector<Vector3>& vertices, const std::vector<Triangle>& triangles,
                                const std::map<DirectedEdge, u32>& left, double tolerance) {
  std::vector<u32> order(triangles.size()), group(triangles.size(), NONE);
  std::vector<Vector3> normals;
  std::vector<double> areas;
  for (const Triangle& t : triangles) {
    normals.push_back(area_normal(vertices, {t[0], t[1], t[2]}));
    areas.push_back(exact::length(normals.back()));
    if (areas.back() > 0) normals.back() = exact::scale(1 / areas.back(), normals.back());
  }
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](u32 a, u32 b) { return areas[a] != areas[b] ? areas[a] > areas[b] : triangles[a] < triangles[b]; });
  for (const u32 seed : order) {
    if (group[seed] != NONE) continue;
    group[seed] = seed;
    std::vector<u32> open = {seed};
    while (!open.empty()) {
      const Triangle t = triangles[open.back()];
      open.pop_back();
      for (unsigned k = 0; k < 3; ++k) {
        const u32 other = left.at({t[(k + 1) % 3], t[k]});
        if (group[other] != NONE) continue;
        const bool flat = std::all_of(triangles[other].begin(), triangles[other].end(), [&](u32 v) {
          return std::abs(dot(normals[seed], subtract(vertices[v], vertices[triangles[seed][0]]))) <= tolerance;
        });
        if (!flat) continue;
        group[other] = seed;
        open.push_back(other);
      }
    }
  }
  return group;
}

// The loops around the groups; empty where one is not a single ring.
std::vector<std::vector<u32>> rings(const std::vector<Triangle>& triangles, const std::map<DirectedEdge, u32>& left,
                                    const std::vector<u32>& group) {
  std::map<u32, std::map<u32, u32>> next;  // group -> corner -> following corner
  for (const auto& [edge, t] : left)
    if (group[left.at({edge.second, edge.first})] != group[t] &&
        !next[group[t]].emplace(edge.first, edge.second).second)
      return {};
  std::vector<std::vector<u32>> faces;
  for (u32 t = 0; t < triangles.size(); ++t) {
    if (group[t] != t) continue;
    const std::map<u32, u32>& around = next[t];
    if (around.empty()) return {};
    std::vector<u32> face = {around.begin()->first};
    for (u32 v = around.begin()->second; v != face[0]; v = around.at(v)) {
      face.push_back(v);
      if (face.size() > around.size()) return {};
    }
    if (face.size() != around.size()) return {};
    faces.push_back(face);
  }
  return faces;
}

// Corners between only two faces lie on a straight edge: they are none.
void drop_straight_corners(std::vector<std::vector<u32>>& faces, std::size_t vertices) {
  std::vector<u32> count(vertices, 0);
  for (const auto& face : faces)
    for (const u32 v : face) ++count[v];
  for (auto& face : faces) std::erase_if(face, [&](u32 v) { return count[v] < 3; });
}

// Only the vertices in use; faces and edges in their canonical order.
ConvexHull assemble(const std::vector<Vector3>& points, std::vector<std::vector<u32>> faces) {
  ConvexHull hull;
  std::vector<u32> name(points.size(), NONE);
  for (const auto& face : faces)
    for (const u32 v : face) name[v] = 0;
  for (u32 v = 0; v < points.size(); ++v) {
    if (name[v] == NONE) continue;
    name[v] = static_cast<u32>(hull.vertices.size());
    hull.vertices.push_back(points[v]);
  }
  for (auto& face : faces) {
    for (u32& v : face) v = name[v];
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  }
  std::sort(faces.begin(), faces.end());
  hull.faces = std::move(faces);

  std::map<DirectedEdge, u32> left;
  for (u32 f = 0; f < hull.faces.size(); ++f) {
    const std::vector<u32>& face = hull.faces[f];
    ConvexHull::Plane plane = {exact::unit(area_normal(hull.vertices, face)), 0};
    plane.offset = dot(plane.normal, hull.vertices[face[0]]);
    for (const u32 v : face) plane.offset = std::max(plane.offset, dot(plane.normal, hull.vertices[v]));
    hull.planes.push_back(plane);
    for (std::size_t i = 0; i < face.size(); ++i) left[{face[i], face[(i + 1) % face.size()]}] = f;
  }
  for (const auto& [edge, f] : left)
    if (edge.first < edge.second)
      hull.edges.push_back({edge.first, edge.second, f, left.at({edge.second, edge.first})});
  return hull;
}

// Of the tetrahedron from the origin to a triangle, counter-clockwise seen from outside.
void add_tetrahedron(const Vector3& a, const Vector3& b, const Vector3& c, VolumeMoments& m) {
  constexpr unsigned row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  const double volume = dot(a, cross(b, c)) / 6;
  const Vector3 sum = exact::add(exact::add(a, b), c);
  m.volume += volume;
  m.first = exact::add(m.first, exact::scale(volume / 4, sum));
  for (unsigned k = 0; k < 6; ++k) {
    const unsigned r = row[k], s = column[k];
    m.second[k] += volume / 20 * (a[r] * a[s] + b[r] * b[s] + c[r] * c[s] + sum[r] * sum[s]);
  }
}

}  // namespace

ConvexHull convex_hull(const std::vector<Vector3>& given, std::string& refusal) {
  refusal.clear();
  for (const Vector3& p : given)
    for (const double x : p)
      if (!(std::abs(x) <= 1e15)) {
        refusal = fmt::format("its points must be finite and below 1e15 m, one has the coordinate {}", x);
        return {};
      }
  std::vector<Vector3> points = given;
  for (Vector3& p : points)
    for (double& x : p) x += 0.0;  // no negative zero, which would sort apart from zero
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  refusal = refuse(points);
  if (!refusal.empty()) return {};

  // the mean of the points is inside the hull: what facets turn their backs to
  Vector3 inner = points[0];
  for (const Vector3& p : points) {
    inner = exact::add(inner, exact::scale(1.0 / static_cast<double>(points.size()), subtract(p, points[0])));
  }
  double size = 0;
  for (const Vector3& p : points) size = std::max(size, exact::length(subtract(p, inner)));
  std::vector<Triangle> triangles = facets_by_qhull(points);
  for (Triangle& t : triangles) {
    if (dot(area_normal(points, {t[0], t[1], t[2]}), subtract(points[t[0]], inner)) < 0) std::swap(t[1], t[2]);
  }
  std::sort(triangles.begin(), triangles.end());
  const auto left = neighbours(triangles);
  std::vector<std::vector<u32>> faces;
  if (left) faces = rings(triangles, *left, group_coplanar(points, triangles, *left, coplanar * size));
  drop_straight_corners(faces, points.size());
  const bool whole =
      faces.size() >= 4 && std::all_of(faces.begin(), faces.end(), [](const auto& f) { return f.size() >= 3; });
  if (!whole) {
    refusal = "its points are too close to each other, or too nearly in one plane, to make a hull; remove some";
    return {};
  }
  ConvexHull hull = assemble(points, std::move(faces));
  if (hull.vertices.size() > most_hull_vertices) {
    refusal = fmt::format("its hull has {} corners, it can have {}; give fewer points", hull.vertices.size(),
                          most_hull_vertices);
    return {};
  }
  return hull;
}

Vector3 center_of_box(std::span<const Vector3> points) {
  Vector3 low = points[0], high = points[0];
  for (const Vector3& p : points) {
    for (unsigned i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  }
  return exact::scale(0.5, exact::add(low, high));
}

std::string set_hull(const std::vector<Vector3>& points, ShapeDescription& shape) {
  std::string refusal;
  ConvexHull hull = convex_hull(points, refusal);
  if (!refusal.empty()) return refusal;
  const Vector3 center = center_of_box(hull.vertices);
  for (Vector3& v : hull.vertices) v = exact::subtract(v, center);
  shape.points = std::move(hull.vertices);
  shape.offset = exact::add(shape.offset, exact::rotate(shape.rotation, center));
  return {};
}

Vector3 half_extents_of(std::span<const Vector3> points) {
  Vector3 half = {0, 0, 0};
  for (const Vector3& p : points)
    for (unsigned i = 0; i < 3; ++i) half[i] = std::max(half[i], std::abs(p[i]));
  return half;
}

VolumeMoments volume_moments(const ConvexHull& hull) {
  VolumeMoments m;
  for (const std::vector<u32>& face : hull.faces) {
    for (std::size_t i = 1; i + 1 < face.size(); ++i)
      add_tetrahedron(hull.vertices[face[0]], hull.vertices[face[i]], hull.vertices[face[i + 1]], m);
  }
  return m;
}

VolumeMoments volume_moments(const TriangleMesh& mesh) {
  VolumeMoments m;
  for (const auto& [a, b, c] : mesh.triangles) add_tetrahedron(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], m);
  return m;
}

ShapeDescription bounding_cube(const ShapeDescription& shape) {
  const auto box = [&](std::span<const Vector3> corners) {
    const Vector3 half = half_extents_of(corners);
    const double most = std::max({half[0], half[1], half[2]});
    return ShapeDescription{.kind = SHAPE_BOX, .offset = shape.offset, .half_extents = {most, most, most}};
  };
  switch (shape.kind) {
    case SHAPE_HULL: return box(shape.points);
    case SHAPE_MESH: return box(shape.mesh->vertices);
    case SHAPE_FACET: return box(shape.surface->mesh.vertices);
    default: return shape;
  }
}

}  // namespace lockstep
