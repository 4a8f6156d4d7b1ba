// Which shapes lie flush with others that do not move against them (cpu_reference/shapes/seams.hpp): found where a
// scene is compiled, so that each step knows them.
#pragma once

#include <span>

#include "host/scene/compile.hpp"

namespace lockstep {

/// Finds the boxes, hulls and facets of bodies that nothing pushes, static ones with each other and those of one
/// kinematic body, of which others touch an edge. Sets the feature, the flags of such shapes, the tables and their
/// size; a facet whose edge another surface goes on over gets a hull of its own. The shapes of `state` are those of
/// `worlds`.
template <class real>
void compile_seams(std::span<const Scene> worlds, InitialState<real>& state);

}  // namespace lockstep
