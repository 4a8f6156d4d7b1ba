// Readers of mesh files in this process: small, and as strict as the formats are. Numbers are rounded to float, as
// these files have them. All throw std::runtime_error for what is no such file, in a line that says where, and Error
// (input) where the JSON of a glTF file makes no sense.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "host/scene/scene.hpp"

namespace lockstep {

inline constexpr std::size_t most_mesh_corners = 1u << 26;  // of all triangles of a file

/// Wavefront: `v` and `f`; vertices in the order in which faces name them, all of them where there is no face.
TriangleMesh read_obj(std::string_view text);
/// Binary or text; corners as they come, three for each triangle.
TriangleMesh read_stl(std::string_view bytes);
/// Text, or binary of either order.
TriangleMesh read_ply(std::string_view bytes);
/// glTF 2.0, JSON or binary (glb): the default scene, its nodes' frames applied. `file` gives the bytes of a file named
/// beside it.
TriangleMesh read_gltf(const std::string& bytes, const std::string& source,
                       const std::function<std::string(const std::string& name)>& file);
/// Of a kind that assimp reads: in a process of its own, with limits of memory and time, that opens no file.
TriangleMesh read_by_assimp(const std::string& bytes, const std::string& ending);

/// Adds a polygon of these corners as triangles: what is convex as a fan from its first one.
void add_polygon(const std::vector<u32>& corners, TriangleMesh& mesh);

}  // namespace lockstep
