#include "host/scene/few_corners.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "host/scene/hull.hpp"

namespace lockstep {

namespace {

constexpr double near = 1e-6;  // of the size: what sticks out by less is left

// The points of the surface of a cube of edge 2 n that have whole coordinates.
std::vector<Vector3> directions(int n) {
  std::vector<Vector3> all;
  for (int x = -n; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z)
        if (std::max({std::abs(x), std::abs(y), std::abs(z)}) == n)
          all.push_back({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
  return all;
}

// The numbers of the points that are farthest out in some of the directions, the first where several are.
std::vector<std::size_t> farthest(const std::vector<Vector3>& points, const std::vector<Vector3>& directions) {
  std::vector<std::size_t> found;
  for (const Vector3& d : directions) {
    std::size_t best = 0;
    double most = exact::dot(d, points[0]);
    for (std::size_t i = 1; i < points.size(); ++i) {
      const double out = exact::dot(d, points[i]);
      if (out > most) most = out, best = i;
    }
    found.push_back(best);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

double outside(const ConvexHull& hull, const Vector3& p) {
  double most = -1;
  for (const ConvexHull::Plane& plane : hull.planes) most = std::max(most, exact::dot(plane.normal, p) - plane.offset);
  return most;
}

// Each within -1 .. 1 along x, y and z.
std::vector<Vector3> scaled_by_size(std::vector<Vector3> points) {
  const Vector3 center = center_of_box(points);
  for (Vector3& p : points) p = exact::subtract(p, center);
  const Vector3 half = half_extents_of(points);
  for (Vector3& p : points)
    for (unsigned i = 0; i < 3; ++i)
      if (half[i] > 0) p[i] /= half[i];
  return points;
}

}  // namespace

std::vector<Vector3> few_corners(const std::vector<Vector3>& given) {
  const auto is_finite = [](const Vector3& p) {
    return std::all_of(p.begin(), p.end(), [](double x) { return std::abs(x) <= 1e15; });
  };
  if (given.size() <= most_hull_vertices || !std::all_of(given.begin(), given.end(), is_finite)) return given;
  std::vector<Vector3> points = given;  // in an order of their own: how a file lists them does not count
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  const std::vector<Vector3> scaled = scaled_by_size(points);
  std::vector<std::size_t> chosen = farthest(scaled, directions(2));
  const std::vector<std::size_t> candidates = farthest(scaled, directions(6));
  while (chosen.size() < most_hull_vertices) {
    std::vector<Vector3> corners;
    for (const std::size_t i : chosen) corners.push_back(scaled[i]);
    std::string refusal;
    const ConvexHull hull = convex_hull(corners, refusal);
    if (!refusal.empty()) break;
    double most = near;
    std::size_t next = points.size();
    for (const std::size_t i : candidates) {
      const double out = outside(hull, scaled[i]);
      if (out > most) most = out, next = i;
    }
    if (next == points.size()) break;
    chosen.push_back(next);
  }
  std::vector<Vector3> few;
  for (const std::size_t i : chosen) few.push_back(points[i]);
  return few;
}

}  // namespace lockstep
