// A step starts with a clean slate: no lists, no status.
#pragma once

#include <algorithm>

#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
void begin_step(Buffers<real>& b, const StepParams<real>&) {
  std::fill(b.counters.begin(), b.counters.end(), 0u);
}

}  // namespace lockstep::reference
