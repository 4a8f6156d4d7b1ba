// The shapes "hull" and "mesh" of a scene file: from points, from the vertices of a mesh file or from its triangles.
#pragma once

#include "host/scene/json_node.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// Sets the points of a shape whose offset and rotation are read already, and moves its origin to the middle of the box
/// that holds them.
void read_hull(const JsonNode& node, ShapeDescription& shape);

/// Sets the mesh of a shape of the kind mesh. Refuses one that bounds no solid.
void read_solid_mesh(const JsonNode& node, ShapeDescription& shape);

}  // namespace lockstep
