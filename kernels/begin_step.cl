#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "types.h"

// A step starts with a clean slate: no lists, no status.
kernel void begin_step(global u32* counters) { FOR_EACH(i, COUNTER_COUNT) counters[i] = 0u; }
