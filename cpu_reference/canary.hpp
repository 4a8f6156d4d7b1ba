// Twin of kernels/canary.cl: small sums, quotients and roots that show a device, or a host, that rounds otherwise.
#pragma once

#include <vector>

#include "kernels/types.h"

namespace lockstep::reference {

/// CANARY_CASES results for each of `count` operand sets; that of case k and set i is at k * count + i.
template <class real>
std::vector<real> canary(u32 count);

/// Whether this thread rounds to nearest and keeps denormals, as operands and as results.
bool host_arithmetic_is_default();

}  // namespace lockstep::reference
