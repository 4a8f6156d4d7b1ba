// The shape "hull" of a scene file: from points, or from the vertices of a mesh.
#pragma once

#include "host/scene/json_node.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// Sets the points of a shape whose offset and rotation are read already, and moves its origin to the middle of the box
/// that holds them.
void read_hull(const JsonNode& node, ShapeDescription& shape);

/// The vertices of all meshes of a file, as they stand in its scene (assimp: obj, stl, ply, gltf and others). Throws
/// std::runtime_error where it holds none.
std::vector<Vector3> mesh_vertices(const std::string& path);

}  // namespace lockstep
