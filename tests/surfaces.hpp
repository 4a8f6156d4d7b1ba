// Bodies whose shapes are triangles.
#pragma once

#include "host/scene/surface.hpp"

namespace lockstep {

/// A cube about the origin, 12 triangles.
inline TriangleMesh cube_mesh(double half) {
  TriangleMesh mesh;
  for (unsigned i = 0; i < 8; ++i)
    mesh.vertices.push_back({i & 1 ? half : -half, i & 2 ? half : -half, i & 4 ? half : -half});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A static body of the triangles of a mesh.
inline BodyDescription surface_body(const TriangleMesh& mesh, const Vector3& position = {0, 0, 0}) {
  std::string flaw;
  ShapeDescription whole;
  whole.kind = SHAPE_FACET;
  whole.surface = make_surface(mesh, flaw);
  BodyDescription body;
  body.kind = BODY_STATIC;
  body.position = position;
  body.shapes = {whole};
  return body;
}

/// Heights of so many points each way, a function of x and y.
template <class Height>
TriangleMesh hills(u32 points, double spacing, Height&& height) {
  std::vector<std::vector<double>> rows(points, std::vector<double>(points));
  for (u32 j = 0; j < points; ++j)
    for (u32 i = 0; i < points; ++i)
      rows[j][i] = height((i - 0.5 * (points - 1)) * spacing, (j - 0.5 * (points - 1)) * spacing);
  return height_field(rows, spacing);
}

}  // namespace lockstep
