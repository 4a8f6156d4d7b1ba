// The couplings of joints of a scene.
#pragma once

#include "host/scene/json_node.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// Reads the array `couplings` of a scene that has all joints. Throws Error (input) with the path of what is wrong.
std::vector<CouplingDescription> read_couplings(const JsonNode& array, const Scene& scene);

/// Of couplings that were made in code.
void validate_couplings(const Scene& scene);

}  // namespace lockstep
