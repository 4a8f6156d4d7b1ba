// The parameters of a step, from the settings of a scene.
#pragma once

#include "host/buffers.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// Throws Error (input) where a setting does not fit the precision.
template <class real>
StepParams<real> make_params(const Scene& scene, const Sizes& sizes, Features features);

/// The parameters that say how long the buffers are.
template <class real>
void set_sizes(StepParams<real>& params, const Sizes& sizes);

}  // namespace lockstep
