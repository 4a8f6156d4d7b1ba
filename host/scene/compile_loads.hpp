// Loads from outside, and those that support a share of a body's weight (gravcomp of MJCF).
#pragma once

#include <span>

#include "host/buffers.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// Whether loads act in a scene, or will. Throws Error (input) where its integrator knows none.
bool has_loads(std::span<const Scene> worlds);

/// At the centres of mass; to the buffer of loads, which is there where a scene has such bodies.
template <class real>
void support_weights(std::span<const Scene> worlds, Buffers<real>& buffers);

}  // namespace lockstep
