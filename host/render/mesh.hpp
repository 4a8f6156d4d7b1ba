// Triangles of the shapes, in the frame of the shape and, but for hulls, of size 1: instances scale them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kernels/types.h"

namespace lockstep {

struct Vertex {
  Eigen::Vector3f position, normal;
};

/// Triangles are counter-clockwise seen from outside.
struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<u32> indices;
};

/// Radius 1, from an icosahedron whose faces are halved `level` times: 20 * 4^level triangles.
Mesh sphere_mesh(u32 level);

/// Half extents 1.
Mesh box_mesh();

/// Radius 1 about z, from z = -1 to 1; `capped` or open at the ends.
Mesh cylinder_mesh(u32 segments, bool capped);

/// Half a sphere of radius 1, with z >= 0.
Mesh hemisphere_mesh(u32 segments);

/// A convex polytope of flat faces: corners of face f are `corners[first[f]] ... corners[first[f + 1] - 1]`.
Mesh polytope_mesh(const std::vector<Eigen::Vector3f>& points, const std::vector<u32>& first,
                   const std::vector<u32>& corners);

}  // namespace lockstep
