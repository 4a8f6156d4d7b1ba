// Where a particle is, and with what two that touch push each other. cpu_reference/particle.hpp is the twin and has the
// formulas.
#ifndef LOCKSTEP_PARTICLE_H
#define LOCKSTEP_PARTICLE_H

#include "grid.h"
#include "rigid_body.h"

static inline Vec4 vec4_of(Vec3 a, real w) {
  Vec4 v;
  v.x = a.x;
  v.y = a.y;
  v.z = a.z;
  v.w = w;
  return v;
}

static inline void place_particle(u32 i, global const u32* particle_bodies, global const Vec4* particle_offsets,
                                  global const Vec4* positions, global const Vec4* orientations,
                                  global const Motion* motions, global Vec4* particle_places,
                                  global Vec4* particle_velocities) {
  const u32 body = particle_bodies[i];
  const Vec3 arm = rotate3(quat(orientations[body]), vec3_of(particle_offsets[i]));
  particle_places[i] = vec4_of(add3(vec3_of(positions[body]), arm), (real)0);
  particle_velocities[i] = vec4_of(point_velocity(&motions[body], arm), (real)0);
}

typedef struct Push {
  Vec3 force, moment;
} Push;

static inline Push push_of(ParticleLaw law, Vec3 n, real overlap, Vec3 arm, Vec3 u, real mass) {
  const real root = sqrt(mass);
  const real u_n = dot3(n, u);
  const real pressure = law.stiffness * overlap - law.damping * root * u_n;
  const real normal = pressure > (real)0 ? pressure : (real)0;
  Vec3 shear = scale3(law.shear_damping * root, sub3(u, scale3(u_n, n)));
  const real size = length3(shear), most = law.friction * normal;
  if (size > most) shear = scale3(most / size, shear);
  Push push;
  push.force = sub3(shear, scale3(normal, n));
  push.moment = cross3(arm, push.force);
  return push;
}

#endif
