// What is done to bodies from outside while a simulation runs: done in the first place, and done again from a
// recording.
#pragma once

#include "host/record/recording.hpp"
#include "host/simulation.hpp"

namespace lockstep {

/// Does it, before a step: overwrites velocities and lets loads act. `loads` is the caller's copy of what acts on each
/// body, empty in a scene without Feature::loads.
template <class real>
void act(std::span<const InputRow> inputs, Backend<real>& backend, std::vector<Load<real>>& loads);

}  // namespace lockstep
