#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "types.h"

// Counts the steps that were done; an aborted step will be redone and does not count.
kernel void end_step(global u32* step_index, global const u32* counters) {
  FOR_EACH(i, 1u) {
    if (!STEP_ABORTED(counters)) step_index[i] += 1u;
  }
}
