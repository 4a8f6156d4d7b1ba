#include "host/scene/sample_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "host/scene/triangle_mesh.hpp"

namespace lockstep {

namespace {

using exact::add, exact::scale, exact::subtract;

// In parts of the radius: candidates on the surface, particles, and a surface point and its particle.
constexpr double candidate_spacing = 0.5, least_spacing = 1.5, farthest = 4;

// Particles that keep their distance.
class Kept {
 public:
  explicit Kept(double spacing) : spacing_(spacing) {}

  bool add_if_separated(const Vector3& p) {
    if (is_within(p, spacing_)) return false;
    cells_[{cell(p[0]), cell(p[1]), cell(p[2])}].push_back(p);
    return true;
  }
  bool is_within(const Vector3& p, double max_distance) const {
    for (long x = cell(p[0] - max_distance); x <= cell(p[0] + max_distance); ++x) {
      for (long y = cell(p[1] - max_distance); y <= cell(p[1] + max_distance); ++y) {
        for (long z = cell(p[2] - max_distance); z <= cell(p[2] + max_distance); ++z) {
          const auto found = cells_.find({x, y, z});
          if (found == cells_.end()) continue;
          for (const Vector3& q : found->second) {
            const Vector3 d = subtract(p, q);
            if (exact::dot(d, d) < max_distance * max_distance) return true;
          }
        }
      }
    }
    return false;
  }

 private:
  long cell(double x) const { return static_cast<long>(std::floor(x / spacing_)); }

  double spacing_;
  std::map<std::array<long, 3>, std::vector<Vector3>> cells_;
};

// Calls `function(point, normal)` for the points of a lattice on each triangle, its corners among them.
template <class Function>
void for_each_surface_point(const TriangleMesh& mesh, double spacing, Function&& function) {
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3 &origin = mesh.vertices[a], ab = subtract(mesh.vertices[b], origin),
                  ac = subtract(mesh.vertices[c], origin);
    const Vector3 across = exact::cross(ab, ac);
    if (across == Vector3{0, 0, 0}) continue;
    const double longest = std::max({exact::length(ab), exact::length(ac), exact::length(subtract(ab, ac))});
    const double divisions = std::max(std::ceil(longest / spacing), 1.0);
    const Vector3 normal = exact::unit(across);
    for (double i = 0; i <= divisions; ++i)
      for (double j = 0; i + j <= divisions; ++j)
        function(add(origin, add(scale(i / divisions, ab), scale(j / divisions, ac))), normal);
  }
}

// The point at this depth below the surface, from a point near it; false where the solid is too thin to have one there.
bool settle(const MeshSearch& search, double depth, Vector3& p) {
  for (unsigned round = 0; round < 20; ++round) {
    const MeshSearch::Nearest near = search.nearest(p, 2 * depth);
    if (!near.found || !(near.distance > 0)) return false;
    if (std::abs(near.distance - depth) <= 1e-6 * depth) return search.contains(p);
    p = add(near.point, scale(depth / near.distance, subtract(p, near.point)));
  }
  return false;
}

void add_lattice(const TriangleMesh& mesh, const MeshSearch& search, double radius, std::vector<Vector3>& particles) {
  Vector3 low = mesh.vertices[0], high = low;
  for (const Vector3& v : mesh.vertices) {
    for (unsigned k = 0; k < 3; ++k) low[k] = std::min(low[k], v[k]), high[k] = std::max(high[k], v[k]);
  }
  const double spacing = 2 * radius;
  Vector3 first, count;  // centred, so that symmetric solids have symmetric particles
  for (unsigned k = 0; k < 3; ++k) {
    count[k] = std::floor((high[k] - low[k]) / spacing);
    first[k] = 0.5 * (low[k] + high[k]) - 0.5 * (count[k] - 1) * spacing;
  }
  for (double x = 0; x < count[0]; ++x) {
    for (double y = 0; y < count[1]; ++y) {
      for (double z = 0; z < count[2]; ++z) {
        const Vector3 p = add(first, scale(spacing, {x, y, z}));
        if (search.contains(p) && !search.nearest(p, 3 * radius).found) particles.push_back(p);
      }
    }
  }
}

}  // namespace

std::vector<Vector3> sample_mesh(const TriangleMesh& mesh, double radius, Sampling sampling, std::string& refusal) {
  const MeshSearch search(mesh, radius);
  std::vector<Vector3> particles;
  Kept kept(least_spacing * radius);
  for_each_surface_point(mesh, candidate_spacing * radius, [&](const Vector3& point, const Vector3& normal) {
    Vector3 p = subtract(point, scale(radius, normal));
    if (settle(search, radius, p) && kept.add_if_separated(p)) particles.push_back(p);
  });
  for_each_surface_point(mesh, radius, [&](const Vector3& point, const Vector3&) {
    if (!refusal.empty() || kept.is_within(point, farthest * radius)) return;
    refusal = fmt::format(
        "is too thin near ({:.6g}, {:.6g}, {:.6g}) of the mesh for particles of the radius {:.6g} m; make them smaller",
        point[0], point[1], point[2], radius);
  });
  if (sampling == Sampling::solid) add_lattice(mesh, search, radius, particles);
  return particles;
}

}  // namespace lockstep
