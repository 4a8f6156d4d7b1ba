// Surfaces that bodies collide with triangle by triangle: meshes and height fields of static and kinematic bodies. In
// exact arithmetic (exact_math.hpp).
#pragma once

#include <string>

#include "host/scene/scene.hpp"

namespace lockstep {

/// A triangle and what is around it (cpu_reference/shapes/facet.hpp). Edge k runs from corner k to the next.
struct Facet {
  Vector3 normal;                          // unit, out of the solid
  std::array<Vector3, 3> across;           // the right side of each edge, as Hull in kernels/types.h says
  std::array<std::vector<u32>, 3> around;  // of corners that nothing rises above, or at the rim: those around them
  u32 owned = 0, rim = 0;                  // as those of Hull
};

struct Surface {
  TriangleMesh mesh;          // welded
  std::vector<Facet> facets;  // one a triangle
};

/// The surface of a mesh, which may have an edge; vertices at one position are made one. Where it is none (no
/// triangles, one without area, more than two at an edge or two turned against each other) `flaw` says why, with a
/// place, and what to do. All vertices must be finite.
std::shared_ptr<const Surface> make_surface(const TriangleMesh& mesh, std::string& flaw);

/// The middle of the box around a facet, where the origin of its shape is.
Vector3 middle_of_facet(const Surface& surface, u32 facet);

/// Its corners, seen from there.
std::vector<Vector3> corners_of_facet(const Surface& surface, u32 facet);

/// The facets as shapes of a body, each as `whole` but for its kind and place: offset and rotation of `whole` are those
/// of the surface.
std::vector<ShapeDescription> facets_of(const ShapeDescription& whole);

/// Heights of a grid, row by row along y and along x within a row, `spacing` m apart, about the middle of the grid.
/// Each cell is two triangles that meet at the diagonal from its corner of least x and y. At least two rows of two, all
/// of one length.
TriangleMesh height_field(const std::vector<std::vector<double>>& rows, double spacing);

}  // namespace lockstep
