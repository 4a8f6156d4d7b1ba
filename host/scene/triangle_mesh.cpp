#include "host/scene/triangle_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "host/scene/hull.hpp"

namespace lockstep {

namespace {

using exact::add, exact::cross, exact::dot, exact::scale, exact::subtract;

std::string flaw_of_edges(const TriangleMesh& mesh) {
  std::string flaw;
  const TrianglesAtEdges edges = triangles_at_edges(mesh, flaw);
  if (!flaw.empty()) return flaw;
  for (const auto& [edge, triangle] : edges) {
    if (edges.count({edge.second, edge.first})) continue;
    return fmt::format("is open: triangle {} has no neighbour at its edge from {} to {}; close the hole", triangle,
                       point_text(mesh.vertices[edge.first]), point_text(mesh.vertices[edge.second]));
  }
  return "";
}

// Six times the volume of a tetrahedron.
double volume_of(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  return dot(subtract(a, d), cross(subtract(b, d), subtract(c, d)));
}

// Whether the segment passes through the inside of the triangle.
bool pierces(const Vector3& p, const Vector3& q, const Vector3& a, const Vector3& b, const Vector3& c) {
  const double from = volume_of(a, b, c, p), to = volume_of(a, b, c, q);
  if (!((from > 0 && to < 0) || (from < 0 && to > 0))) return false;
  const double u = volume_of(p, q, a, b), v = volume_of(p, q, b, c), w = volume_of(p, q, c, a);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

struct Box {
  Vector3 low, high;
  u32 triangle;
};

bool overlap(const Box& a, const Box& b) {
  for (unsigned k = 0; k < 3; ++k)
    if (a.low[k] > b.high[k] || b.low[k] > a.high[k]) return false;
  return true;
}

// Triangles that share a corner may meet there.
bool cut_each_other(const TriangleMesh& mesh, u32 s, u32 t) {
  for (const auto& [one, two] : {std::pair(s, t), std::pair(t, s)}) {
    const auto& [a, b, c] = mesh.triangles[one];
    for (unsigned k = 0; k < 3; ++k) {
      const u32 p = mesh.triangles[two][k], q = mesh.triangles[two][(k + 1) % 3];
      if (p == a || p == b || p == c || q == a || q == b || q == c) continue;
      if (pierces(mesh.vertices[p], mesh.vertices[q], mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]))
        return true;
    }
  }
  return false;
}

// Sweeps along x.
std::string flaw_of_crossings(const TriangleMesh& mesh) {
  std::vector<Box> boxes;
  for (u32 t = 0; t < mesh.triangles.size(); ++t) {
    Box box = {mesh.vertices[mesh.triangles[t][0]], mesh.vertices[mesh.triangles[t][0]], t};
    for (const u32 corner : mesh.triangles[t]) {
      for (unsigned k = 0; k < 3; ++k) {
        box.low[k] = std::min(box.low[k], mesh.vertices[corner][k]);
        box.high[k] = std::max(box.high[k], mesh.vertices[corner][k]);
      }
    }
    boxes.push_back(box);
  }
  std::sort(boxes.begin(), boxes.end(), [](const Box& a, const Box& b) {
    return a.low[0] != b.low[0] ? a.low[0] < b.low[0] : a.triangle < b.triangle;
  });
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes.size() && boxes[j].low[0] <= boxes[i].high[0]; ++j) {
      if (!overlap(boxes[i], boxes[j]) || !cut_each_other(mesh, boxes[i].triangle, boxes[j].triangle)) continue;
      return fmt::format("cuts itself: its triangles {} and {} cross near {}; make it one surface",
                         std::min(boxes[i].triangle, boxes[j].triangle), std::max(boxes[i].triangle, boxes[j].triangle),
                         point_text(mesh.vertices[mesh.triangles[boxes[i].triangle][0]]));
    }
  }
  return "";
}

// Of a triangle (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
Vector3 closest_point(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 ab = subtract(b, a), ac = subtract(c, a), ap = subtract(p, a);
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vector3 bp = subtract(p, b);
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return add(a, scale(d1 / (d1 - d3), ab));
  const Vector3 cp = subtract(p, c);
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return add(a, scale(d2 / (d2 - d6), ac));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return add(b, scale((d4 - d3) / ((d4 - d3) + (d5 - d6)), subtract(c, b)));
  const double whole = va + vb + vc;
  return add(a, add(scale(vb / whole, ab), scale(vc / whole, ac)));
}

// On which side of the line from a to b the point is, seen along z. Both triangles at an edge get the same answer, and
// so do edges above each other: it is worked out from the end that comes first. A point on the line counts as moved by
// a trifle along x and by less along y, so that all triangles agree on where it is.
bool is_left(const Vector3& p, const Vector3& a, const Vector3& b) {
  if (std::pair(b[0], b[1]) < std::pair(a[0], a[1])) return !is_left(p, b, a);
  const double x = b[0] - a[0], y = b[1] - a[1], side = x * (p[1] - a[1]) - y * (p[0] - a[0]);
  return side != 0 ? side > 0 : y != 0 ? y < 0 : x > 0;
}

// Whether the triangle is below the point, along z; one that stands upright is not.
bool is_below(const TriangleMesh& mesh, const std::array<u32, 3>& t, const Vector3& p) {
  const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  const Vector3 n = cross(subtract(b, a), subtract(c, a));
  const bool left = is_left(p, a, b);
  if (n[2] == 0 || is_left(p, b, c) != left || is_left(p, c, a) != left) return false;
  const double side = dot(n, subtract(p, a));
  return n[2] > 0 ? side > 0 : side < 0;
}

std::uint64_t key_of(long x, long y, long z) {
  constexpr std::uint64_t mask = (1u << 21) - 1;
  return (static_cast<std::uint64_t>(x) & mask) << 42 | (static_cast<std::uint64_t>(y) & mask) << 21 |
         (static_cast<std::uint64_t>(z) & mask);
}

// Keeps the first of the vertices at each position, and says which of those kept stands for each. Numbers in a table
// that is half empty, found by a mix of the position's bits.
std::vector<u32> weld(std::vector<Vector3>& vertices) {
  std::vector<u32> number_of(vertices.size());
  std::vector<u32> table(std::bit_ceil(2 * vertices.size() + 1), NONE);
  u32 kept = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    std::uint64_t mix = 0;
    for (const double x : vertices[i]) {
      mix = (mix ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15u;  // -0 is 0
      mix ^= mix >> 29;
    }
    std::size_t slot = mix & (table.size() - 1);
    while (table[slot] != NONE && vertices[table[slot]] != vertices[i]) slot = (slot + 1) & (table.size() - 1);
    if (table[slot] == NONE) {
      table[slot] = kept;
      vertices[kept++] = vertices[i];
    }
    number_of[i] = table[slot];
  }
  vertices.resize(kept);
  return number_of;
}

}  // namespace

std::string point_text(const Vector3& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", p[0], p[1], p[2]); }

std::string edge_run_twice(const TriangleMesh& mesh, u32 s, u32 t, u32 from, u32 to) {
  return fmt::format(
      "its triangles {} and {} run the same way along the edge from {} to {}, so that one is turned around or "
      "more than two meet; make it a surface whose triangles are all counter-clockwise seen from outside",
      s, t, point_text(mesh.vertices[from]), point_text(mesh.vertices[to]));
}

TrianglesAtEdges triangles_at_edges(const TriangleMesh& mesh, std::string& flaw) {
  TrianglesAtEdges edges;
  for (u32 t = 0; t < mesh.triangles.size(); ++t) {
    for (unsigned k = 0; k < 3; ++k) {
      const u32 a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      const auto [other, is_new] = edges.try_emplace({a, b}, t);
      if (is_new) continue;
      flaw = edge_run_twice(mesh, other->second, t, a, b);
      return edges;
    }
  }
  return edges;
}

TriangleMesh welded(TriangleMesh mesh) {
  const std::vector<u32> number_of = weld(mesh.vertices);
  std::size_t kept = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::array<u32, 3> t = {number_of[a], number_of[b], number_of[c]};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles[kept++] = t;
  }
  mesh.triangles.resize(kept);
  return mesh;
}

std::string flaw_of(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return "has no triangles; give a mesh that bounds a solid";
  if (const std::string flaw = flaw_of_edges(mesh); !flaw.empty()) return flaw;
  const double volume = volume_moments(mesh).volume;
  if (volume < 0) return fmt::format("is inside out, its volume is {:.6g} m^3; turn its triangles around", volume);
  if (!(volume > 0)) return "has no volume; give a mesh that bounds a solid";
  return flaw_of_crossings(mesh);
}

MeshSearch::MeshSearch(const TriangleMesh& mesh, double max_distance) : mesh_(mesh), size_(2 * max_distance) {
  const auto cell = [&](double x) { return static_cast<long>(std::floor(x / size_)); };
  for (u32 t = 0; t < mesh.triangles.size(); ++t) {
    Vector3 low = mesh.vertices[mesh.triangles[t][0]], high = low;
    for (const u32 corner : mesh.triangles[t]) {
      for (unsigned k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], mesh.vertices[corner][k]);
        high[k] = std::max(high[k], mesh.vertices[corner][k]);
      }
    }
    for (long x = cell(low[0]); x <= cell(high[0]); ++x) {
      for (long y = cell(low[1]); y <= cell(high[1]); ++y) {
        columns_[key_of(x, y, 0)].push_back(t);
        for (long z = cell(low[2]); z <= cell(high[2]); ++z) cells_[key_of(x, y, z)].push_back(t);
      }
    }
  }
}

const std::vector<u32>& MeshSearch::at(const Cells& cells, long x, long y, long z) const {
  static const std::vector<u32> none;
  const auto found = cells.find(key_of(x, y, z));
  return found == cells.end() ? none : found->second;
}

MeshSearch::Nearest MeshSearch::nearest(const Vector3& p, double max_distance) const {
  const auto cell = [&](double x) { return static_cast<long>(std::floor(x / size_)); };
  Nearest best;
  double least = max_distance * max_distance;
  for (long x = cell(p[0] - max_distance); x <= cell(p[0] + max_distance); ++x) {
    for (long y = cell(p[1] - max_distance); y <= cell(p[1] + max_distance); ++y) {
      for (long z = cell(p[2] - max_distance); z <= cell(p[2] + max_distance); ++z) {
        for (const u32 t : at(cells_, x, y, z)) {
          const auto& [a, b, c] = mesh_.triangles[t];
          const Vector3 q = closest_point(p, mesh_.vertices[a], mesh_.vertices[b], mesh_.vertices[c]);
          const Vector3 d = subtract(p, q);
          if (!(dot(d, d) < least)) continue;
          least = dot(d, d);
          best = {true, exact::square_root(least), q};
        }
      }
    }
  }
  return best;
}

bool MeshSearch::contains(const Vector3& p) const {
  const auto cell = [&](double x) { return static_cast<long>(std::floor(x / size_)); };
  bool inside = false;
  for (const u32 t : at(columns_, cell(p[0]), cell(p[1]), 0))
    if (is_below(mesh_, mesh_.triangles[t], p)) inside = !inside;
  return inside;
}

}  // namespace lockstep
