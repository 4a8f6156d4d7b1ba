#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "particle.h"
#include "types.h"

kernel void update_particles(global const u32* body_particles, global const u32* particle_bodies,
                             global const Vec4* particle_offsets, global const Vec4* positions,
                             global const Vec4* orientations, global const Motion* motions,
                             global Vec4* particle_positions, global Vec4* particle_velocities,
                             global const u32* counters, const StepParams params) {
  if (STEP_ABORTED(counters) || params.substep + 1u == params.substeps) return;
  FOR_EACH(i, body_particles[params.bodies]) {
    update_particle(i, particle_bodies, particle_offsets, positions, orientations, motions, particle_positions,
                    particle_velocities);
  }
}
