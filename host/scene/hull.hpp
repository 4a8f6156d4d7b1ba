// Convex hulls of points. Which points are corners of which facet is found by qhull; everything that becomes simulated
// state - planes, the merging of coplanar facets, the order of the tables - is computed here, in exact arithmetic
// (exact_math.hpp), from the points as given.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"
#include "kernels/types.h"

namespace lockstep {

/// Every edge of one hull is held against every edge of the other.
constexpr u32 most_hull_vertices = 128;

/// Facets closer to a plane than this, relative to the size of the hull, are one face.
constexpr double coplanar = 1e-6;

/// A convex polyhedron. Equal sets of points, in any order, give equal tables: vertices are sorted by x, y, z; faces
/// start with their smallest vertex and are sorted; edges are sorted.
struct ConvexHull {
  struct Plane {
    Vector3 normal;  // unit, outward
    double offset;   // normal . x <= offset inside
  };

  std::vector<Vector3> vertices;
  std::vector<Plane> planes;            // of the faces
  std::vector<std::vector<u32>> faces;  // corners, counter-clockwise seen from outside
  std::vector<HullEdge> edges;          // vertex_a < vertex_b
};

/// The hull of points; where they have none, an empty one, and `refusal` says why and what to do.
ConvexHull convex_hull(const std::vector<Vector3>& points, std::string& refusal);

/// Gives a shape the hull of these points, which stand in its frame, and moves its origin to the middle of the box that
/// holds them. Where they have none it is left alone, and what is returned says why and what to do; else that is empty.
std::string set_hull(const std::vector<Vector3>& points, ShapeDescription& shape);

/// The middle of the smallest box along the axes that holds the points.
Vector3 center_of_box(std::span<const Vector3> points);

/// Half extents of the smallest such box about the origin.
Vector3 half_extents_of(std::span<const Vector3> points);

/// The cube around a hull, a mesh or a surface, whose own numbers may be millions; other shapes as they are.
ShapeDescription bounding_cube(const ShapeDescription& shape);

/// Volume, its first moments and its second moments xx, yy, zz, xy, xz, yz about the origin, from signed tetrahedra
/// with their tips there (Mirtich 1996 gives the same by other means).
struct VolumeMoments {
  double volume = 0;
  Vector3 first = {0, 0, 0};
  std::array<double, 6> second = {};
};
VolumeMoments volume_moments(const ConvexHull& hull);
VolumeMoments volume_moments(const TriangleMesh& mesh);

}  // namespace lockstep
