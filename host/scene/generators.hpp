// Generators: a few lines of a scene file that place many bodies.
#pragma once

#include "host/scene/read_bodies.hpp"

namespace lockstep {

/// Reads a generator ("grid", "line", "pyramid" or "arc") and appends the bodies it places.
void expand_generator(const JsonNode& node, Names& names, BodyList& list);

}  // namespace lockstep
