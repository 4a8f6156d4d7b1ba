#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "particle.h"
#include "types.h"

static inline void add_push(Push* sum, Push push) {
  sum->force = add3(sum->force, push.force);
  sum->moment = add3(sum->moment, push.moment);
}

static inline Vec3 spin_of(global const Motion* motion) { return make3(motion->w[0], motion->w[1], motion->w[2]); }

kernel void push_particles(global const WorldRange* world_ranges, global const ParticleLaw* particle_laws,
                           global const real* particle_shares, global const BodyInfo* body_infos,
                           global const u32* body_particles, global const u32* particle_bodies,
                           global const ParticlePlane* particle_planes, global const u32* plane_bodies,
                           global const Vec4* positions, global const Vec4* orientations, global const Motion* motions,
                           global const Vec4* particle_places, global const Vec4* particle_velocities,
                           global const u32* neighbour_starts, global const u32* neighbours,
                           global Vec4* particle_forces, global Vec4* particle_moments, global const u32* counters,
                           const StepParams params) {
  if (STEP_IS_VOID(counters)) return;
  FOR_EACH(i, body_particles[params.bodies]) {
    const u32 body = particle_bodies[i];
    const BodyInfo info = body_infos[body];
    const ParticleLaw law = particle_laws[info.world];
    const Vec3 zero = make3((real)0, (real)0, (real)0);
    Push sum = {zero, zero};
    if (info.kind == BODY_DYNAMIC) {
      const Vec3 x = vec3_of(particle_places[i]), v = vec3_of(particle_velocities[i]), w = spin_of(&motions[body]);
      const real share = particle_shares[body];

      const WorldRange world = world_ranges[info.world];
      for (u32 k = world.first_plane; k < world.first_plane + world.plane_count; ++k) {
        const u32 body_p = plane_bodies[k];
        const Vec3 x_p = vec3_of(positions[body_p]);
        const Quat q = quat(orientations[body_p]);
        const ParticlePlane plane = particle_planes[k];
        const Vec3 normal = rotate3(q, vec3(plane.normal));
        const Vec3 point = add3(x_p, rotate3(q, vec3(plane.point)));
        const real overlap = law.radius - dot3(normal, sub3(x, point));
        if (!(overlap > (real)0)) continue;
        const Vec3 arm = scale3((real)0.5 * overlap - law.radius, normal);
        const Vec3 there = point_velocity(&motions[body_p], sub3(add3(x, arm), x_p));
        const Vec3 here = add3(v, cross3(w, arm));
        add_push(&sum, push_of(law, scale3((real)-1, normal), overlap, arm, sub3(there, here), (real)1 / share));
      }

      for (u32 k = neighbour_starts[i]; k < neighbour_starts[i + 1u]; ++k) {
        const u32 j = neighbours[k];
        const Vec3 d = sub3(vec3_of(particle_places[j]), x);
        const real distance_ij = length3(d), overlap = (real)2 * law.radius - distance_ij;
        if (!(overlap > (real)0) || !(distance_ij > (real)0)) continue;
        const u32 other = particle_bodies[j];
        const Vec3 n = scale3((real)1 / distance_ij, d);
        const real lever = (real)0.5 * distance_ij;
        const Vec3 arm = scale3(lever, n);
        const Vec3 here = add3(v, cross3(w, arm));
        const Vec3 there = add3(vec3_of(particle_velocities[j]), cross3(spin_of(&motions[other]), scale3(-lever, n)));
        add_push(&sum, push_of(law, n, overlap, arm, sub3(there, here), (real)1 / (share + particle_shares[other])));
      }
    }
    particle_forces[i] = vec4_of(sum.force, (real)0);
    particle_moments[i] = vec4_of(sum.moment, (real)0);
  }
}
