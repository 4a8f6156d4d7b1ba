// The errors of a step, wherever it was computed.
#pragma once

#include "host/backends/backend.hpp"
#include "host/report/measures.hpp"

namespace lockstep {

/// Of the state of a backend after a step with these parameters and counters; an oracle tells its own residual.
template <class real>
Measures measure(Backend<real>& backend, const StepParams<real>& params, const Counters& counters) {
  const Buffers<real>& buffers = backend.download(measured_buffers(backend.features()));
  Measures of = measure(buffers, backend.sizes(), backend.features(), params, counters);
  backend.take_own_residual(of);
  return of;
}

}  // namespace lockstep
