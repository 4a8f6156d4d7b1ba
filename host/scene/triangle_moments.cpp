#include "host/scene/triangle_moments.hpp"

#include "host/scene/hull.hpp"

namespace lockstep {

namespace {

using Corners = std::array<Vector3, 3>;

Corners corners_of(const TriangleMesh& mesh, const std::array<u32, 3>& triangle, const Vector3& from) {
  Corners corners;
  for (unsigned k = 0; k < 3; ++k) corners[k] = exact::subtract(mesh.vertices[triangle[k]], from);
  return corners;
}

Vector3 sum_of(const Corners& c) { return exact::add(exact::add(c[0], c[1]), c[2]); }

double area_of(const Corners& c) {
  return 0.5 * exact::length(exact::cross(exact::subtract(c[1], c[0]), exact::subtract(c[2], c[0])));
}

double volume_of(const Corners& c, bool is_unsigned) {
  const double volume = exact::dot(c[0], exact::cross(c[1], c[2])) / 6;
  return is_unsigned && volume < 0 ? -volume : volume;
}

// xx, yy, zz, xy, xz, yz of the integral of x x^T over a simplex with a corner at 0: the content times this.
using Products = std::array<double, 6>;

void add_products(double content, const Corners& c, Products& all) {
  constexpr unsigned of[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  const Vector3 sum = sum_of(c);
  for (unsigned k = 0; k < 6; ++k) {
    const auto [i, j] = of[k];
    const double own = c[0][i] * c[0][j] + c[1][i] * c[1][j] + c[2][i] * c[2][j];
    all[k] += content * (own + sum[i] * sum[j]);
  }
}

MassProperties properties_of(double mass, const Vector3& center, const Products& p) {
  return {mass, center, {p[1] + p[2], p[0] + p[2], p[0] + p[1], -p[3], -p[4], -p[5]}};
}

struct Middle {
  double area = 0;
  Vector3 center = {0, 0, 0};
};

Middle middle_of(const TriangleMesh& mesh) {
  Middle all;
  Vector3 sum = {0, 0, 0};
  for (const std::array<u32, 3>& triangle : mesh.triangles) {
    const Corners c = corners_of(mesh, triangle, {0, 0, 0});
    const double area = area_of(c);
    all.area += area;
    sum = exact::add(sum, exact::scale(area / 3, sum_of(c)));
  }
  if (all.area > 0) all.center = exact::scale(1 / all.area, sum);
  return all;
}

}  // namespace

MassProperties shell_moments(const TriangleMesh& mesh) {
  const Middle all = middle_of(mesh);
  Products products = {};
  for (const std::array<u32, 3>& triangle : mesh.triangles) {
    const Corners c = corners_of(mesh, triangle, all.center);
    add_products(area_of(c) / 12, c, products);
  }
  return properties_of(all.area, all.center, products);
}

MassProperties solid_moments(const TriangleMesh& mesh, bool unsigned_volumes) {
  const Vector3 middle = middle_of(mesh).center;
  double volume = 0;
  Vector3 sum = {0, 0, 0};
  for (const std::array<u32, 3>& triangle : mesh.triangles) {
    const Corners c = corners_of(mesh, triangle, middle);
    const double v = volume_of(c, unsigned_volumes);
    volume += v;
    sum = exact::add(sum, exact::scale(v / 4, sum_of(c)));
  }
  if (!(volume > 0)) return {};
  const Vector3 center = exact::add(middle, exact::scale(1 / volume, sum));
  volume = 0;
  Products products = {};
  for (const std::array<u32, 3>& triangle : mesh.triangles) {
    const Corners c = corners_of(mesh, triangle, center);
    const double v = volume_of(c, unsigned_volumes);
    volume += v;
    add_products(v / 20, c, products);
  }
  return properties_of(volume, center, products);
}

TriangleMesh hull_triangles(const std::vector<Vector3>& points) {
  std::string refusal;
  const ConvexHull hull = convex_hull(points, refusal);
  TriangleMesh mesh;
  if (!refusal.empty()) return mesh;
  mesh.vertices = hull.vertices;
  for (const std::vector<u32>& face : hull.faces)
    for (std::size_t k = 1; k + 1 < face.size(); ++k) mesh.triangles.push_back({face[0], face[k], face[k + 1]});
  return mesh;
}

}  // namespace lockstep
