// The reference: plain C++ twins of the kernels. A stage works on host buffers and computes the kernels' bits.
#pragma once

#include "host/stages.hpp"

namespace lockstep::reference {

/// Runs the twin of one stage. Compiled in the library only, without contraction (contract rule 1).
template <class real>
void run_stage(Stage stage, Buffers<real>& buffers, const StepParams<real>& params);

}  // namespace lockstep::reference
