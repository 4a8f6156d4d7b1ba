#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "particle.h"
#include "types.h"

// Where the springs of each particle begin: entry i is the number of keys whose particle is below i.
kernel void match_springs_index(global const u32* spring_count, global const SpringKey* spring_keys,
                                global u32* spring_starts, global const u32* body_particles, const StepParams params) {
  const u32 springs = spring_count[0], particles = body_particles[params.bodies];
  FOR_EACH(k, springs + 1u) {
    const u32 first = k > 0u ? spring_keys[k - 1u].particle + 1u : 0u;
    const u32 last = k < springs ? spring_keys[k].particle : particles;
    for (u32 i = first; i <= last; ++i) spring_starts[i] = k;
  }
}

// Both lists of a particle are in order.
kernel void match_springs(global const u32* body_particles, global const u32* neighbour_starts,
                          global const u32* neighbours, global const SpringKey* spring_keys,
                          global const Vec4* spring_stretches, global const u32* spring_starts, global Vec4* stretches,
                          global const u32* counters, const StepParams params) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(i, body_particles[params.bodies]) {
    u32 at = spring_starts[i];
    const u32 end = spring_starts[i + 1u];
    for (u32 k = neighbour_starts[i]; k < neighbour_starts[i + 1u]; ++k) {
      while (at < end && spring_keys[at].partner < neighbours[k]) ++at;
      const bool known = at < end && spring_keys[at].partner == neighbours[k];
      stretches[k] = known ? spring_stretches[at] : vec4_of(make3((real)0, (real)0, (real)0), (real)0);
    }
  }
}
