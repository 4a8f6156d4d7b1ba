// Binary files of MuJoCo: heights of the ground, and meshes.
#pragma once

#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep {

struct Elevations {
  std::size_t rows = 0, columns = 0;
  std::vector<double> heights;  // row after row, the first nearest along y; in any unit
};

/// A picture (PNG, as grey, 0 .. 255, its top farthest along y), or MuJoCo's own: two integers, rows and columns, and
/// the heights in float. Throws std::runtime_error.
Elevations read_elevations(const std::string& path);

/// A mesh of MuJoCo's own format: four integers, how many vertices, normals, texture coordinates and triangles there
/// are, and these in float and int. Throws std::runtime_error.
TriangleMesh read_msh(const std::string& path);

}  // namespace lockstep
