#pragma once

#include "cpu_reference/math.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
void update_bounds(Buffers<real>&, const StepParams<real>&) {}

}  // namespace lockstep::reference
