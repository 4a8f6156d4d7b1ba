// Mesh files.
#pragma once

#include <string>

#include "host/scene/scene.hpp"

namespace lockstep {

/// All meshes of a file, as they stand in its scene; those of the built-in scenes are in the library. Of other files
/// only the buffers of a glTF file are read, in its folder. Throws std::runtime_error where it has no mesh.
TriangleMesh read_mesh(const std::string& path);

/// How many triangles a file says that it has at least, found without reading them: by the header of STL and PLY, the
/// lines of OBJ. 0 where it does not say, or cannot be opened.
std::size_t triangles_announced(const std::string& path);

/// Whether a built-in scene uses this one.
bool is_embedded_mesh(const std::string& path);

}  // namespace lockstep
