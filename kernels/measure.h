// The largest of what a stage sees, in a counter. cpu_reference/measure.hpp is the twin and says more.
#ifndef LOCKSTEP_MEASURE_H
#define LOCKSTEP_MEASURE_H

#include "types.h"

static inline void raise_maximum(volatile global u32* counters, u32 counter, real value) {
  if (value > (real)0) atomic_max(&counters[counter], as_uint((float)value));
}

#endif
