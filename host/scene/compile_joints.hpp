// From the joints of scenes to constant buffers: frames in both bodies, colours, blocks, and who does not collide.
#pragma once

#include <span>

#include "host/scene/compile.hpp"

namespace lockstep {

/// Adds the joints of the worlds to a state that has all bodies, and sets their sizes and features. Throws Error
/// (input) where settings and joints do not go together.
template <class real>
void compile_joints(std::span<const Scene> worlds, InitialState<real>& state);

}  // namespace lockstep
