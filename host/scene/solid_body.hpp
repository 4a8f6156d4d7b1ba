// Bodies whose mass, centre and axes follow from their shapes: make_solid() and its like, which the library has.
#pragma once

#include "host/scene/scene.hpp"
#include "include/lockstep/scene.hpp"

namespace lockstep {

/// Whether it has any shape that has a mass: triggers have none.
bool has_solid_shapes(const BodyDescription& body);

}  // namespace lockstep
