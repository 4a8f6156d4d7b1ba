// Whether contacts are possible at all in a scene.
#pragma once

#include "host/scene/scene.hpp"

namespace lockstep {

/// Whether any two shapes of different bodies could ever touch: one of the bodies is dynamic, the filters of both
/// shapes agree, and at least one of them is no plane.
bool shapes_can_touch(const Scene& scene);

}  // namespace lockstep
