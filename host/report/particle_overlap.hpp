// How deep particles are in each other and in planes.
#pragma once

#include "host/report/measures.hpp"

namespace lockstep {

/// Exact distances at the poses of the step's end, of the neighbours that the step found and of all planes; each pair
/// counts once.
template <class real>
Penetration particle_overlap(const Buffers<real>& buffers);

}  // namespace lockstep
