#pragma OPENCL FP_CONTRACT OFF
// Makes bodies whole again after their parts were solved (cpu_reference/mass_splitting.hpp).
#include "common.h"
#include "mass_splitting.h"
#include "types.h"

kernel void mean_parts(const u32 bodies, global const u32* part_starts, global const Velocity* body_parts,
                       global Motion* motions, global const u32* counters) {
  if (SWEEP_IS_VOID(counters)) return;
  FOR_EACH(i, bodies) part_mean(i, part_starts, body_parts, motions);
}
