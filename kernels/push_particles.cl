#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "particle.h"
#include "types.h"

static inline Vec3 angular_velocity_of(global const Motion* motion) {
  return make3(motion->w[0], motion->w[1], motion->w[2]);
}

// What a push reads.
typedef struct Pushed {
  global const real* shares;
  global const u32* bodies;
  global const Vec4* particle_positions;
  global const Vec4* velocities;
  global const ParticlePlane* planes;
  global const u32* plane_bodies;
  global const Vec4* positions;
  global const Vec4* orientations;
  global const Motion* motions;
} Pushed;

static inline Touch touch_of_plane(const Pushed* p, ParticleLaw law, u32 i, u32 k) {
  const u32 body = p->bodies[i], body_p = p->plane_bodies[k];
  const Vec3 x = vec3_of(p->particle_positions[i]), x_p = vec3_of(p->positions[body_p]);
  const CurrentPlane plane = current_plane(p->planes[k], x_p, quat(p->orientations[body_p]));
  Touch touch;
  touch.overlap = law.radius - dot3(plane.normal, sub3(x, plane.point));
  touch.n = scale3((real)-1, plane.normal);
  touch.arm = scale3((real)0.5 * touch.overlap - law.radius, plane.normal);
  const Vec3 there = point_velocity(&p->motions[body_p], sub3(add3(x, touch.arm), x_p));
  const Vec3 here = add3(vec3_of(p->velocities[i]), cross3(angular_velocity_of(&p->motions[body]), touch.arm));
  touch.u = sub3(there, here);
  touch.mass = (real)1 / p->shares[body];
  return touch;
}

static inline Touch touch_of_neighbour(const Pushed* p, ParticleLaw law, u32 i, u32 j) {
  const Vec3 d = sub3(vec3_of(p->particle_positions[j]), vec3_of(p->particle_positions[i]));
  const real distance_ij = length3(d);
  const u32 body_i = p->bodies[i], body_j = p->bodies[j];
  Touch touch;
  touch.overlap = distance_ij > (real)0 ? (real)2 * law.radius - distance_ij : (real)0;
  touch.n = scale3((real)1 / distance_ij, d);
  const real half_distance = (real)0.5 * distance_ij;
  touch.arm = scale3(half_distance, touch.n);
  const Vec3 here = add3(vec3_of(p->velocities[i]), cross3(angular_velocity_of(&p->motions[body_i]), touch.arm));
  const Vec3 there = add3(vec3_of(p->velocities[j]),
                          cross3(angular_velocity_of(&p->motions[body_j]), scale3(-half_distance, touch.n)));
  touch.u = sub3(there, here);
  touch.mass = (real)1 / (p->shares[body_i] + p->shares[body_j]);
  return touch;
}

kernel void push_particles(global const ParticleLaw* particle_laws, global const real* particle_shares,
                           global const BodyInfo* body_infos, global const u32* body_particles,
                           global const u32* particle_bodies, global const ParticlePlane* particle_planes,
                           global const u32* plane_bodies, global const Vec4* positions,
                           global const Vec4* orientations, global const Motion* motions,
                           global const Vec4* particle_positions, global const Vec4* particle_velocities,
                           global const u32* neighbour_starts, global const u32* neighbours, global Vec4* stretches,
                           global Vec4* particle_forces, global Vec4* particle_moments, global const u32* counters,
                           const StepParams params) {
  if (STEP_ABORTED(counters)) return;
  const Pushed p = {particle_shares,     particle_bodies, particle_positions,
                    particle_velocities, particle_planes, plane_bodies,
                    positions,           orientations,    motions};
  const u32 particles = body_particles[params.bodies];
  FOR_EACH(i, particles) {
    const u32 begin = neighbour_starts[i], end = neighbour_starts[i + 1u];
    const Vec3 zero = make3((real)0, (real)0, (real)0);
    Push sum = {zero, zero};
    if (begin < end) {
      const ParticleLaw law = particle_laws[body_infos[particle_bodies[i]].world];
      for (u32 k = begin; k < end; ++k) {
        const u32 j = neighbours[k];
        const Touch touch =
            j < particles ? touch_of_neighbour(&p, law, i, j) : touch_of_plane(&p, law, i, j - particles);
        Vec3 stretch = zero;  // of what does not touch
        if (touch.overlap > (real)0) {
#if FEATURE_SHEAR_SPRINGS
          if (law.shear_stiffness > (real)0) stretch = vec3_of(stretches[k]);
#endif
          const Push push = push_of(law, touch, params.dt, &stretch);
          sum.force = add3(sum.force, push.force);
          sum.moment = add3(sum.moment, push.moment);
        }
#if FEATURE_SHEAR_SPRINGS
        if (law.shear_stiffness > (real)0) stretches[k] = vec4_of(stretch, (real)0);
#endif
      }
    }
    particle_forces[i] = vec4_of(sum.force, (real)0);
    particle_moments[i] = vec4_of(sum.moment, (real)0);
  }
}
