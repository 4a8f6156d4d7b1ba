// Solvers along a gradient, of solve_constraints.
#pragma once

#include "host/device/launcher.hpp"

namespace lockstep {

/// Enqueues a whole descent (kernels/solve_by_gradient.cl); `fused`: in one work-group.
void solve_by_gradient(Launcher& launcher, bool fused);

}  // namespace lockstep
