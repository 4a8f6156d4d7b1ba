// Mesh files.
#pragma once

#include <string>

#include "host/scene/scene.hpp"

namespace lockstep {

/// All meshes of a file, as they stand in its scene (assimp: obj, stl, ply, gltf and others); those of the built-in
/// scenes are in the library. Throws std::runtime_error where it holds none.
TriangleMesh read_mesh(const std::string& path);

/// How many triangles a file says that it has at least, found without reading them: by the header of STL and PLY, the
/// lines of OBJ. 0 where it does not say, or cannot be opened.
std::size_t triangles_announced(const std::string& path);

/// Whether a built-in scene uses this one.
bool is_embedded_mesh(const std::string& path);

}  // namespace lockstep
