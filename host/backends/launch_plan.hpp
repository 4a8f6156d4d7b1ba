// How large the launches of a step are: from what there may be at first, then from the counters of the step before.
#pragma once

#include <vector>

#include "host/backends/backend.hpp"
#include "host/device/fused_substeps.hpp"
#include "host/scene/compile.hpp"

namespace lockstep {

template <class real>
LaunchPlan first_plan(const InitialState<real>& state, u32 lanes);

/// The plan of sub-steps by one team: nothing is large.
LaunchPlan fused_plan(LaunchPlan plan);

void update_plan(LaunchPlan& plan, const Counters& counters);

/// What sub-steps write of the state.
std::vector<Buffer> state_of(const FusedSubsteps& fused, Features features);

}  // namespace lockstep
