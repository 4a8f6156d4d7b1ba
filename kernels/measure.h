// The largest of what a stage sees, in a counter. cpu_reference/measure.hpp is the twin and says more.
#ifndef LOCKSTEP_MEASURE_H
#define LOCKSTEP_MEASURE_H

#include "types.h"

static inline void raise_maximum(volatile global u32* counters, u32 counter, real value) {
  const u32 bits = as_uint((float)value);
  if (value > (real)0 && bits > counters[counter]) atomic_max(&counters[counter], bits);
}

#endif
