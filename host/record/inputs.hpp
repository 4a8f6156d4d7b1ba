// What is done to bodies and joints from outside while a simulation runs: done in the first place, and done again from
// a recording.
#pragma once

#include "host/record/recording.hpp"
#include "host/simulation.hpp"

namespace lockstep {

/// Of a state, its driven_buffers.
template <class real>
Buffers<real> driven_by_inputs(const Buffers<real>& state);

/// Whether a spring acts along the free coordinate.
template <class real>
bool has_spring(const Joint<real>& joint) {
  return joint.side_compliance > 0 || joint.spring_compliance > 0;
}

/// Where it rests, m or rad.
template <class real>
real spring_rest(const Joint<real>& joint) {
  return joint.side_compliance > 0 ? joint.side_rest : joint.low;
}

/// Does it, before a step: overwrites velocities, lets loads act, drives motors, moves springs and pulls otherwise;
/// restores are none of it. `driven` is the caller's copy of what the backend holds of these, and is kept up.
template <class real>
void act(std::span<const InputRow> inputs, Simulation<real>& simulation, Buffers<real>& driven);

}  // namespace lockstep
