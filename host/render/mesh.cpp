#include "host/render/mesh.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <utility>

namespace lockstep {

using Eigen::Vector3f;

namespace {

void add_face(Mesh& mesh, const std::vector<Vector3f>& corners, const Vector3f& normal) {
  const u32 first = static_cast<u32>(mesh.vertices.size());
  for (const Vector3f& corner : corners) mesh.vertices.push_back({corner, normal});
  for (u32 i = 2; i < corners.size(); ++i) mesh.indices.insert(mesh.indices.end(), {first, first + i - 1, first + i});
}

Vector3f on_circle(u32 i, u32 segments, float z) {
  const double angle = 2 * EIGEN_PI * i / segments;
  return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), z};
}

// Two triangles between neighbours of two rows of vertices; the second row is on the left of the first.
void add_strip(Mesh& mesh, u32 lower, u32 upper, u32 segments) {
  for (u32 i = 0; i < segments; ++i) {
    const u32 a = lower + i, b = a + 1, c = upper + i, d = c + 1;
    mesh.indices.insert(mesh.indices.end(), {a, b, d, a, d, c});
  }
}

}  // namespace

Mesh sphere_mesh(u32 level) {
  const float g = (1 + std::sqrt(5.0f)) / 2;
  Mesh mesh;
  for (const Vector3f& p : {Vector3f(-1, g, 0), Vector3f(1, g, 0), Vector3f(-1, -g, 0), Vector3f(1, -g, 0),
                            Vector3f(0, -1, g), Vector3f(0, 1, g), Vector3f(0, -1, -g), Vector3f(0, 1, -g),
                            Vector3f(g, 0, -1), Vector3f(g, 0, 1), Vector3f(-g, 0, -1), Vector3f(-g, 0, 1)})
    mesh.vertices.push_back({p.normalized(), p.normalized()});
  mesh.indices = {0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4,  11, 10, 2,  10, 7, 6, 7, 1, 8,
                  3, 9,  4, 3, 4, 2, 3, 2, 6, 3, 6, 8,  3, 8,  9,  4, 9, 5, 2, 4,  11, 6,  2,  10, 8,  6, 7, 9, 8, 1};
  for (; level > 0; --level) {
    std::map<std::pair<u32, u32>, u32> middles;
    const auto middle = [&](u32 a, u32 b) {
      const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<u32>(mesh.vertices.size()));
      if (is_new) {
        const Vector3f p = (mesh.vertices[a].position + mesh.vertices[b].position).normalized();
        mesh.vertices.push_back({p, p});
      }
      return found->second;
    };
    std::vector<u32> finer;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const u32 a = mesh.indices[i], b = mesh.indices[i + 1], c = mesh.indices[i + 2];
      const u32 ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca});
    }
    mesh.indices = std::move(finer);
  }
  return mesh;
}

Mesh box_mesh() {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      const Vector3f normal = side * Vector3f::Unit(axis);
      const Vector3f u = Vector3f::Unit((axis + 1) % 3), v = side * Vector3f::Unit((axis + 2) % 3);
      add_face(mesh, {normal - u - v, normal + u - v, normal + u + v, normal - u + v}, normal);
    }
  }
  return mesh;
}

Mesh cylinder_mesh(u32 segments, bool capped) {
  Mesh mesh;
  for (const float z : {-1.0f, 1.0f}) {
    for (u32 i = 0; i <= segments; ++i) mesh.vertices.push_back({on_circle(i, segments, z), on_circle(i, segments, 0)});
  }
  add_strip(mesh, 0, segments + 1, segments);
  if (!capped) return mesh;
  for (const float z : {-1.0f, 1.0f}) {
    std::vector<Vector3f> rim;
    for (u32 i = 0; i < segments; ++i) rim.push_back(on_circle(z > 0 ? i : segments - i, segments, z));
    add_face(mesh, rim, {0, 0, z});
  }
  return mesh;
}

Mesh hemisphere_mesh(u32 segments) {
  Mesh mesh;
  const u32 rings = std::max(segments / 4, 1u);
  for (u32 ring = 0; ring <= rings; ++ring) {
    const double angle = EIGEN_PI / 2 * ring / rings;
    for (u32 i = 0; i <= segments; ++i) {
      Vector3f p = static_cast<float>(std::cos(angle)) * on_circle(i, segments, 0);
      p.z() = static_cast<float>(std::sin(angle));
      mesh.vertices.push_back({p, p});
    }
    if (ring > 0) add_strip(mesh, (ring - 1) * (segments + 1), ring * (segments + 1), segments);
  }
  return mesh;
}

Mesh polytope_mesh(const std::vector<Vector3f>& points, const std::vector<u32>& first,
                   const std::vector<u32>& corners) {
  Mesh mesh;
  for (std::size_t face = 0; face + 1 < first.size(); ++face) {
    std::vector<Vector3f> outline;
    for (u32 i = first[face]; i < first[face + 1]; ++i) outline.push_back(points[corners[i]]);
    Vector3f normal = Vector3f::Zero();  // Newell's, for corners that rounding took off the plane
    for (std::size_t i = 0; i < outline.size(); ++i) normal += outline[i].cross(outline[(i + 1) % outline.size()]);
    add_face(mesh, outline, normal.normalized());
  }
  return mesh;
}

}  // namespace lockstep
