// Polygons as triangles, by cutting ears (Meisters, Polygons have ears, American Mathematical Monthly, 1975).
#include <algorithm>
#include <stdexcept>

#include "host/scene/mesh_formats.hpp"

namespace lockstep {

namespace {

using exact::add, exact::cross, exact::dot, exact::subtract;

constexpr std::size_t most_corners_of_polygon = 4096;  // ears are looked for in the square of it

// Twice the area, along the normal (Newell).
Vector3 area_of_polygon(const std::vector<u32>& corners, const std::vector<Vector3>& vertices) {
  Vector3 area = {0, 0, 0};
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    area = add(area, cross(subtract(vertices[corners[i]], vertices[corners[0]]),
                           subtract(vertices[corners[i + 1]], vertices[corners[0]])));
  return area;
}

struct Ears {
  const std::vector<Vector3>& vertices;
  const Vector3 normal;

  double side(u32 a, u32 b, u32 c) const {
    return dot(normal, cross(subtract(vertices[b], vertices[a]), subtract(vertices[c], vertices[a])));
  }
  bool is_ear(const std::vector<u32>& left, std::size_t i) const {
    const u32 a = left[(i + left.size() - 1) % left.size()], b = left[i], c = left[(i + 1) % left.size()];
    if (!(side(a, b, c) > 0)) return false;
    return std::ranges::none_of(left, [&](u32 p) {
      return p != a && p != b && p != c && side(a, b, p) >= 0 && side(b, c, p) >= 0 && side(c, a, p) >= 0;
    });
  }
};

}  // namespace

void add_polygon(const std::vector<u32>& corners, TriangleMesh& mesh) {
  if (corners.size() < 3) return;  // points and lines bound nothing
  if (3 * (mesh.triangles.size() + corners.size()) > most_mesh_corners)
    throw std::runtime_error("has more than 22 million triangles; give it fewer");
  if (corners.size() > most_corners_of_polygon)
    throw std::runtime_error("has a polygon of " + std::to_string(corners.size()) + " corners; 4096 are the most");
  std::vector<u32> left = corners;
  if (left.size() > 3) {
    const Ears ears = {mesh.vertices, area_of_polygon(corners, mesh.vertices)};
    const std::size_t n = corners.size();
    bool is_convex = true;
    for (std::size_t i = 0; i < n; ++i)
      is_convex = is_convex && ears.side(corners[i], corners[(i + 1) % n], corners[(i + 2) % n]) > 0;
    while (!is_convex && left.size() > 3) {
      std::size_t ear = 0;
      while (ear < left.size() && !ears.is_ear(left, ear)) ++ear;
      if (ear == left.size()) break;  // flat, or crossing itself: a fan of what is left
      mesh.triangles.push_back({left[(ear + left.size() - 1) % left.size()], left[ear], left[(ear + 1) % left.size()]});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
    }
  }
  for (std::size_t i = 1; i + 1 < left.size(); ++i) mesh.triangles.push_back({left[0], left[i], left[i + 1]});
}

}  // namespace lockstep
