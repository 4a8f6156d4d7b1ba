// One sweep of the matrix splittings (splitting.cpp), which other methods are built on.
#pragma once

#include "cpu_reference/oracle/lcp/lcp.hpp"

namespace lockstep::oracle::lcp {

/// Whether the splittings can act: each M_ii is positive, or its whole row and column are zero.
bool has_diagonal(const MatrixXd& m);

/// z_i <- projection of z_i - relaxation w_i / M_ii, in order, in place.
void gauss_seidel_sweep(const BoxedLcp& problem, double relaxation, VectorXd& z);

}  // namespace lockstep::oracle::lcp
