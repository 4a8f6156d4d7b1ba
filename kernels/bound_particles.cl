#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "particle.h"
#include "tolerances.h"
#include "types.h"

// A work-item takes many particles, so that the one word of the largest extent is not fought over.
kernel void bound_particles(global const ParticleLaw* particle_laws, global const BodyInfo* body_infos,
                            global const u32* body_particles, global const u32* particle_bodies,
                            global const Vec4* particle_offsets, global const Vec4* positions,
                            global const Vec4* orientations, global const Motion* motions,
                            global Vec4* particle_positions, global Vec4* particle_velocities, global u32* counters,
                            const StepParams params) {
  const real h = step_length(&params);
  u32 largest = 0u;
  FOR_EACH(i, body_particles[params.bodies]) {
    update_particle(i, particle_bodies, particle_offsets, positions, orientations, motions, particle_positions,
                    particle_velocities);
    const u32 body = particle_bodies[i];
    const Vec3 v = make3(motions[body].v[0], motions[body].v[1], motions[body].v[2]);
    const Vec3 w = make3(motions[body].w[0], motions[body].w[1], motions[body].w[2]);
    const real speed = length3(v) + length3(w) * length3(vec3_of(particle_offsets[i]));
    const real radius = particle_laws[body_infos[body].world].radius;
    const real extent =
        radius + shape_margin(&params, own_margin(&params, radius, radius), motions[body].inverse_mass) + h * speed;
    const Vec3 x = vec3_of(particle_positions[i]);
    const bool finite = is_finite(x.x) && is_finite(x.y) && is_finite(x.z) && is_finite(extent);
    note_extent(finite, extent, body, &largest, counters);
  }
  if (largest > 0u) atomic_max(&counters[COUNTER_MAX_EXTENT], largest);
}
