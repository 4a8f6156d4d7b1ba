// Counts the steps that were done; an aborted step will be redone and does not count.
#pragma once

#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
void end_step(Buffers<real>& b, const StepParams<real>&) {
  if (!step_aborted(b.counters)) b.step_index[0] += 1;
}

}  // namespace lockstep::reference
