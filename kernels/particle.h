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

static inline void update_particle(u32 i, global const u32* particle_bodies, global const Vec4* particle_offsets,
                                   global const Vec4* positions, global const Vec4* orientations,
                                   global const Motion* motions, global Vec4* particle_positions,
                                   global Vec4* particle_velocities) {
  const u32 body = particle_bodies[i];
  const Vec3 arm = rotate3(quat(orientations[body]), vec3_of(particle_offsets[i]));
  particle_positions[i] = vec4_of(add3(vec3_of(positions[body]), arm), (real)0);
  particle_velocities[i] = vec4_of(point_velocity(&motions[body], arm), (real)0);
}

typedef struct CurrentPlane {
  Vec3 point, normal;
} CurrentPlane;

static inline CurrentPlane current_plane(ParticlePlane plane, Vec3 position, Quat orientation) {
  CurrentPlane current;
  current.point = add3(position, rotate3(orientation, vec3(plane.point)));
  current.normal = rotate3(orientation, vec3(plane.normal));
  return current;
}

typedef struct Touch {
  real overlap;
  Vec3 n, arm, u;
  real mass;
} Touch;

typedef struct Push {
  Vec3 force, moment;
} Push;

// The stretch is carried on by a sub-step.
static inline Push push_of(ParticleLaw law, Touch touch, real dt, Vec3* stretch) {
  const real root = sqrt(touch.mass);
  const real u_n = dot3(touch.n, touch.u);
  const real pressure = law.stiffness * touch.overlap - law.damping * root * u_n;
  const real normal = pressure > (real)0 ? pressure : (real)0;
  const Vec3 slide = sub3(touch.u, scale3(u_n, touch.n));
  const Vec3 damper = scale3(law.shear_damping * root, slide);
  Vec3 shear = damper;
#if FEATURE_SHEAR_SPRINGS
  const bool springs = law.shear_stiffness > (real)0;
  if (springs) {
    const Vec3 tangential = sub3(*stretch, scale3(dot3(touch.n, *stretch), touch.n));
    *stretch = add3(tangential, scale3(dt, slide));
    shear = add3(scale3(law.shear_stiffness, *stretch), damper);
  }
#endif
  const real size = length3(shear), most = law.friction * normal;
  if (size > most) {
    shear = scale3(most / size, shear);
#if FEATURE_SHEAR_SPRINGS
    if (springs) *stretch = scale3((real)1 / law.shear_stiffness, sub3(shear, damper));
#endif
  }
  Push push;
  push.force = sub3(shear, scale3(normal, touch.n));
  push.moment = cross3(touch.arm, push.force);
  return push;
}

#endif
