#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "types.h"

kernel void store_springs(global const u32* body_particles, global const u32* neighbour_starts,
                          global const u32* neighbours, global const Vec4* stretches, global u32* spring_count,
                          global SpringKey* spring_keys, global Vec4* spring_stretches, global const u32* counters,
                          const StepParams params) {
  if (STEP_ABORTED(counters)) return;
  const u32 particles = body_particles[params.bodies];
  if (get_global_id(0) == 0) spring_count[0] = neighbour_starts[particles];
  FOR_EACH(i, particles) {
    for (u32 k = neighbour_starts[i]; k < neighbour_starts[i + 1u]; ++k) {
      spring_keys[k].particle = i;
      spring_keys[k].partner = neighbours[k];
      spring_stretches[k] = stretches[k];
    }
  }
}
