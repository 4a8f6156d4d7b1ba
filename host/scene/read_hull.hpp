// The shapes "hull", "mesh" and "height_field" of a scene file: from points, from the vertices of a mesh file, from its
// triangles or from heights.
#pragma once

#include "host/scene/json_node.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// Sets the points of a shape whose offset and rotation are read already, and moves its origin to the middle of the box
/// that holds them.
void read_hull(const JsonNode& node, ShapeDescription& shape);

/// Sets the mesh of a shape of the kind mesh. Refuses one that bounds no solid.
void read_solid_mesh(const JsonNode& node, ShapeDescription& shape);

/// Sets the surface of a shape that is to be one of triangles (surface.hpp), from a mesh file or from heights.
void read_surface(const JsonNode& node, ShapeDescription& shape);
void read_height_field(const JsonNode& node, ShapeDescription& shape);

}  // namespace lockstep
