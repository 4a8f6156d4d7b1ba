// One sweep of the matrix splittings (splitting.cpp), which other methods are built on.
#pragma once

#include "cpu_reference/oracle/lcp/watch.hpp"

namespace lockstep::oracle::lcp {

/// What a method of sweeps begins with: z where it fits, 0 where not. False where it ends there: z will do, or the
/// splittings cannot act, for which each M_ii must be positive or its whole row and column zero.
bool may_sweep(const BoxedLcp& problem, Watch& watch, VectorXd& z);

/// z_i <- projection of z_i - relaxation w_i / M_ii, in order, in place.
void gauss_seidel_sweep(const BoxedLcp& problem, double relaxation, VectorXd& z);

}  // namespace lockstep::oracle::lcp
