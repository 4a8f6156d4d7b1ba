// The particles of polyhedra.
#pragma once

#include <string>

#include "host/scene/scene.hpp"

namespace lockstep {

/// In the frame of the mesh, which must be closed (flaw_of). Surface particles are one radius below the surface and at
/// least 1.5 radii apart; none of the surface is farther than four radii from one. Where the mesh is too thin for that,
/// `refusal` says where.
std::vector<Vector3> sample_mesh(const TriangleMesh& mesh, double radius, Sampling sampling, std::string& refusal);

}  // namespace lockstep
