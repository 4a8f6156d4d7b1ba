// What solvers along a gradient read beside contacts and joints (cpu_reference/gradient/solve_by_gradient.hpp).
#pragma once

#include "host/scene/compile.hpp"

namespace lockstep {

/// Writes the law of the descent, and the slots of the sides of joints among those of their bodies, into a state that
/// has all bodies and joints and the feature `gradient`.
template <class real>
void compile_gradient(bool accelerated, InitialState<real>& state);

}  // namespace lockstep
