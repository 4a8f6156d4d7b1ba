#pragma once

#include "cpu_reference/math.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
void hash_state(Buffers<real>&, const StepParams<real>&) {}

}  // namespace lockstep::reference
