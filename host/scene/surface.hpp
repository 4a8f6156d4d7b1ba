// Surfaces that bodies collide with triangle by triangle: meshes and height fields of static and kinematic bodies. In
// exact arithmetic (exact_math.hpp).
#pragma once

#include <string>

#include "host/scene/scene.hpp"

namespace lockstep {

/// Triangles that the surfaces of a scene can have: so many take 1 GB in float.
constexpr u32 most_triangles = 4000000;

/// Why a surface cannot have so many triangles; nothing where it can.
std::string flaw_of_count(std::size_t triangles);

/// What surrounds a triangle: as Facet in kernels/types.h says, of the triangles and the edges of its surface.
struct FacetLinks {
  std::array<u32, 3> next;
  u32 flags = 0;
};

/// The same of FacetEdge.
struct SurfaceEdge {
  Vector3 across;
  u32 next;
};

struct Surface {
  TriangleMesh mesh;               // welded
  std::vector<FacetLinks> facets;  // one a triangle
  std::vector<SurfaceEdge> edges;  // those that are FACET_EDGE_STORED
};

/// Of a facet: unit, out of the solid.
Vector3 normal_of_facet(const Surface& surface, u32 facet);

/// What is on the right side of edge k of a facet, as FacetEdgeKind says.
Vector3 across_facet(const Surface& surface, u32 facet, u32 k);

/// The corner that follows corner k of a facet around their vertex.
u32 next_corner(const Surface& surface, u32 facet, u32 k);

/// The middle of the box around a facet, where the origin of its shape is.
Vector3 middle_of_facet(const Surface& surface, u32 facet);

/// Its corners, seen from there.
std::array<Vector3, 3> corners_of_facet(const Surface& surface, u32 facet);

/// Where that origin is in the body of a shape that is a surface.
Vector3 offset_of_facet(const ShapeDescription& whole, u32 facet);

/// How many shapes are simulated for one of a scene: those of a surface are its facets.
std::size_t simulated_shapes(const ShapeDescription& shape);
std::size_t simulated_shapes(const BodyDescription& body);

/// The description of the one that is simulated as number `shape` of a body.
const ShapeDescription& description_of(const BodyDescription& body, u32 shape);

/// How many triangles a grid of so many heights is.
std::size_t triangles_of_grid(std::size_t rows, std::size_t columns);

}  // namespace lockstep
