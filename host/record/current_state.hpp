// The state of a simulation that runs, as one that another can start from.
#pragma once

#include "host/simulation.hpp"

namespace lockstep {

/// The scene with its state as it is now, the steps done among it, and the loads that act. `start` is what the
/// simulation started from.
template <class real>
InitialState<real> current_state(const InitialState<real>& start, Simulation<real>& simulation);

}  // namespace lockstep
