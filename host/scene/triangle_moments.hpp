// Mass, centre and moments of what triangles enclose, and of triangles themselves.
#pragma once

#include "host/scene/mass_properties.hpp"

namespace lockstep {

/// Of a density of 1 kg/m^3: the sum over tetrahedra from a point to the triangles, which need not be closed. With
/// `unsigned_volumes` each counts as positive, seen from the middle of the surface, and then from the centre of mass:
/// of a closed star-shaped surface the same, whatever the order of its corners (MuJoCo's "legacy").
MassProperties solid_moments(const TriangleMesh& mesh, bool unsigned_volumes);

/// Of 1 kg/m^2.
MassProperties shell_moments(const TriangleMesh& mesh);

/// The triangles of the convex hull of points; none where they have none.
TriangleMesh hull_triangles(const std::vector<Vector3>& points);

}  // namespace lockstep
