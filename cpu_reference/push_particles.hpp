// What acts on each particle: its neighbours in their order, then the planes in theirs. Each particle adds up for
// itself, so that no order is left to chance; the law is in cpu_reference/particle.hpp.
#pragma once

#include "cpu_reference/particle.hpp"

namespace lockstep::reference {

/// A particle of a dynamic body on plane k.
template <class real>
Touch<real> touch_of_plane(const Buffers<real>& b, const ParticleLaw<real>& law, u32 i, u32 k) {
  const u32 body = b.particle_bodies[i], body_p = b.plane_bodies[k];
  const Vec3<real> x = vec3_of(b.particle_positions[i]);
  const CurrentPlane<real> plane = current_plane(b, k);
  const real overlap = law.radius - dot3(plane.normal, sub3(x, plane.point));
  const Vec3<real> arm = scale3(real(0.5) * overlap - law.radius, plane.normal);
  const Vec3<real> there = point_velocity(b.motions[body_p], sub3(add3(x, arm), vec3_of(b.positions[body_p])));
  const Vec3<real> here = add3(vec3_of(b.particle_velocities[i]), cross3(vec3(b.motions[body].w), arm));
  return {overlap, scale3(real(-1), plane.normal), arm, sub3(there, here), real(1) / b.particle_shares[body]};
}

/// Two particles, the first of a dynamic body.
template <class real>
Touch<real> touch_of_neighbour(const Buffers<real>& b, const ParticleLaw<real>& law, u32 i, u32 j) {
  const Vec3<real> d = sub3(vec3_of(b.particle_positions[j]), vec3_of(b.particle_positions[i]));
  const real distance = length3(d), overlap = real(2) * law.radius - distance;
  if (!(distance > real(0))) return {};  // two in one place have no direction
  const u32 body_i = b.particle_bodies[i], body_j = b.particle_bodies[j];
  const Vec3<real> n = scale3(real(1) / distance, d);
  const real half_distance = real(0.5) * distance;
  const Vec3<real> arm = scale3(half_distance, n);
  const Vec3<real> here = add3(vec3_of(b.particle_velocities[i]), cross3(vec3(b.motions[body_i].w), arm));
  const Vec3<real> there =
      add3(vec3_of(b.particle_velocities[j]), cross3(vec3(b.motions[body_j].w), scale3(-half_distance, n)));
  return {overlap, n, arm, sub3(there, here), real(1) / (b.particle_shares[body_i] + b.particle_shares[body_j])};
}

template <class real>
void push_particles(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;
  const u32 particles = static_cast<u32>(b.particle_bodies.size());
  for (u32 i = 0; i < particles; ++i) {
    const ParticleLaw<real>& law = b.particle_laws[b.body_infos[b.particle_bodies[i]].world];
    Push<real> sum = {};
    for (u32 k = b.neighbour_starts[i]; k < b.neighbour_starts[i + 1]; ++k) {
      const u32 j = b.neighbours[k];
      const Touch<real> touch =
          j < particles ? touch_of_neighbour(b, law, i, j) : touch_of_plane(b, law, i, j - particles);
      Vec3<real> stretch = {};  // of what does not touch
      if (touch.overlap > real(0)) {
        if (law.shear_stiffness > real(0)) stretch = vec3_of(b.stretches[k]);
        const Push<real> push = push_of(law, touch, params.dt, stretch);
        sum.force = add3(sum.force, push.force);
        sum.moment = add3(sum.moment, push.moment);
      }
      if (law.shear_stiffness > real(0)) b.stretches[k] = vec4_of(stretch, real(0));
    }
    b.particle_forces[i] = vec4_of(sum.force, real(0));
    b.particle_moments[i] = vec4_of(sum.moment, real(0));
  }
}

}  // namespace lockstep::reference
