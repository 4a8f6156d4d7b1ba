#include "bench/overlap.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace lockstep::bench {

namespace {

struct Plane {
  Vector3 normal, point;
};

/// The z axis of a quaternion's frame.
Vector3 z_axis(const Quaternion& q) {
  return {2 * (q[0] * q[2] + q[3] * q[1]), 2 * (q[1] * q[2] - q[3] * q[0]), 1 - 2 * (q[0] * q[0] + q[1] * q[1])};
}

}  // namespace

Overlap measure_overlap(const Scene& scene, const std::vector<Vector3>& positions) {
  std::vector<Plane> planes;
  double largest = 0;
  for (const BodyDescription& body : scene.bodies) {
    for (const ShapeDescription& shape : body.shapes) {
      largest = std::max(largest, shape.radius);
      if (shape.kind != SHAPE_PLANE) continue;
      Vector3 point = body.position;  // planes stand on bodies without rotation here
      for (int k = 0; k < 3; ++k) point[k] += shape.offset[k];
      planes.push_back({z_axis(shape.rotation), point});
    }
  }

  Overlap overlap;
  double sum = 0;
  const auto add = [&](double depth) {
    if (!(depth > 0)) return;
    ++overlap.pairs;
    overlap.deepest = std::max(overlap.deepest, depth);
    sum += depth;
  };
  const double cell = std::max(2 * largest, 1e-6);
  std::map<std::array<long, 3>, std::vector<u32>> grid;
  for (u32 i = 0; i < scene.bodies.size(); ++i) {
    const auto& shapes = scene.bodies[i].shapes;
    if (shapes.empty() || shapes[0].kind != SHAPE_SPHERE) continue;
    const Vector3& x = positions[i];
    const double radius = shapes[0].radius;
    for (const Plane& plane : planes) {
      double height = 0;
      for (int k = 0; k < 3; ++k) height += plane.normal[k] * (x[k] - plane.point[k]);
      add(radius - height);
    }
    const std::array<long, 3> home = {std::lround(x[0] / cell), std::lround(x[1] / cell), std::lround(x[2] / cell)};
    for (long n = 0; n < 27; ++n) {
      const auto found = grid.find({home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1});
      if (found == grid.end()) continue;
      for (const u32 j : found->second) {
        const Vector3& y = positions[j];
        const double d = std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]);
        add(radius + scene.bodies[j].shapes[0].radius - d);
      }
    }
    grid[home].push_back(i);
  }
  overlap.mean = overlap.pairs ? sum / overlap.pairs : 0;
  return overlap;
}

}  // namespace lockstep::bench
