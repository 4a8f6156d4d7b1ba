// From the couplings of scenes to constant buffers: rows on coordinates of joints, phase after phase.
#pragma once

#include <span>

#include "host/scene/compile.hpp"

namespace lockstep {

/// Adds the couplings of the worlds to a state that has all joints in their blocks. Throws Error (input) where settings
/// and couplings do not go together.
template <class real>
void compile_couplings(std::span<const Scene> worlds, InitialState<real>& state);

}  // namespace lockstep
