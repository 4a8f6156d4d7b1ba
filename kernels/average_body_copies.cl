#pragma OPENCL FP_CONTRACT OFF
// Makes bodies whole again after their copies were solved (cpu_reference/body_copies.hpp).
#include "body_copies.h"
#include "common.h"
#include "types.h"

kernel void average_body_copies(const u32 bodies, global const u32* body_copy_starts,
                                global const Velocity* body_copies, global Motion* motions,
                                global const u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
  FOR_EACH(i, bodies) body_copy_mean(i, body_copy_starts, body_copies, motions);
}
