// When bodies of a scene fall asleep (cpu_reference/fall_asleep.hpp).
#pragma once

#include "host/scene/compile.hpp"

namespace lockstep {

/// Steps of so many seconds that are `after` seconds or just more; at least two, between whose ends a body is seen to
/// be at rest.
u32 sleep_steps(double after, double dt);

/// The feature and its laws, of a scene that has the setting `sleeping` and all bodies and other features by now;
/// everybody is awake. Throws Error (input) where others do not go with it.
template <class real>
void compile_sleeping(const Scene& scene, InitialState<real>& state);

}  // namespace lockstep
