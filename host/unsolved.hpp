// What a solver that promises a residual did not keep of it.
#pragma once

#include <string>

#include "kernels/types.h"

namespace lockstep {

/// The sub-steps that were left with a residual larger than what was asked for, and the worst of them. Of oracles
/// (docs/solvers_oracle.md); a solver that makes so many sweeps promises no residual and leaves nothing unsolved.
struct Unsolved {
  u32 count = 0, worst_step = 0;             // steps count from 0
  double worst_residual = 0, tolerance = 0;  // the residual that was asked for
  std::string worst_stop = {};               // why the solver ended there: "stall", "limit", "infeasible"

  /// Adds those of a later part of the same run.
  void add(const Unsolved& later) {
    if (later.count == 0) return;
    count += later.count;
    if (later.worst_residual <= worst_residual) return;
    worst_step = later.worst_step;
    worst_residual = later.worst_residual;
    tolerance = later.tolerance;
    worst_stop = later.worst_stop;
  }
};

}  // namespace lockstep
