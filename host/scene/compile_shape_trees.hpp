// Trees of the shapes of bodies that nothing pushes (cpu_reference/shape_trees.hpp).
#pragma once

#include "host/scene/compile.hpp"

namespace lockstep {

/// From so many shapes on a static or kinematic body keeps a tree of them.
constexpr u32 fewest_in_tree = 32;

/// Makes the trees of a state that has all bodies and shapes: sets the feature where there are any, their sizes and
/// tables, and the flags of their shapes. Planes are in no tree, nor are shapes of a body that has triggers, which
/// also feel those that sleep.
template <class real>
void compile_shape_trees(InitialState<real>& state);

}  // namespace lockstep
