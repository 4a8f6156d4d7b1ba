#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "grid.h"
#include "rigid_body.h"
#include "types.h"

// Keys are buckets; what has none comes behind all others.
kernel void sort_particles_keys(global const BodyInfo* body_infos, global const u32* body_particles,
                                global const u32* particle_bodies, global const Vec4* particle_positions,
                                global Cell* particle_cells, global u32* keys, global u32* values, global u32* counters,
                                const StepParams params) {
  const real size = cell_size(counters[COUNTER_MAX_EXTENT]);
  FOR_EACH(i, body_particles[params.bodies]) {
    const Vec3 x = vec3_of(particle_positions[i]);
    const u32 body = particle_bodies[i];
    Cell cell = {0, 0, 0, NONE};
    if (in_grid(x.x, size) && in_grid(x.y, size) && in_grid(x.z, size)) {
      cell.x = cell_of(x.x, size);
      cell.y = cell_of(x.y, size);
      cell.z = cell_of(x.z, size);
      cell.bucket = bucket_of(cell.x, row_hash(cell.y, cell.z, body_infos[body].world), params.buckets);
    } else {
      atomic_or(&counters[COUNTER_STATUS], (u32)STATUS_OUT_OF_GRID);
      atomic_max(&counters[COUNTER_BAD_BODY], NONE - body);
    }
    particle_cells[i] = cell;
    keys[i] = cell.bucket < params.buckets ? cell.bucket : params.buckets;
    values[i] = i;
  }
}

// After the sort: each slot in the list ends the buckets since the one before it, and the last one all others.
kernel void sort_particles_starts(global const u32* body_particles, global const u32* keys, global u32* particle_starts,
                                  const StepParams params) {
  const u32 count = body_particles[params.bodies];
  FOR_EACH(i, count + 1u) {
    const u32 first = i == 0u ? 0u : keys[i - 1u] + 1u, last = i == count ? params.buckets : keys[i];
    for (u32 k = first; k <= last; ++k) particle_starts[k] = i;
  }
}
