// What acts on each particle: planes first, in their order, then its neighbours in theirs. Each particle adds up for
// itself, so that no order is left to chance; the law is in cpu_reference/particle.hpp.
#pragma once

#include "cpu_reference/particle.hpp"

namespace lockstep::reference {

/// A particle of a dynamic body on a plane of its world.
template <class real>
Push<real> push_of_plane(const Buffers<real>& b, const ParticleLaw<real>& law, u32 i, u32 k) {
  const u32 body = b.particle_bodies[i], body_p = b.plane_bodies[k];
  const Vec3<real> x = vec3_of(b.particle_places[i]), x_p = vec3_of(b.positions[body_p]);
  const Quat<real> q = quat(b.orientations[body_p]);
  const Vec3<real> normal = rotate3(q, vec3(b.particle_planes[k].normal));
  const Vec3<real> point = add3(x_p, rotate3(q, vec3(b.particle_planes[k].point)));
  const real overlap = law.radius - dot3(normal, sub3(x, point));
  if (!(overlap > real(0))) return {};
  const Vec3<real> arm = scale3(real(0.5) * overlap - law.radius, normal);
  const Vec3<real> there = point_velocity(b.motions[body_p], sub3(add3(x, arm), x_p));
  const Vec3<real> here = add3(vec3_of(b.particle_velocities[i]), cross3(vec3(b.motions[body].w), arm));
  return push_of(law, scale3(real(-1), normal), overlap, arm, sub3(there, here), real(1) / b.particle_shares[body]);
}

/// Two particles, the first of a dynamic body.
template <class real>
Push<real> push_of_neighbour(const Buffers<real>& b, const ParticleLaw<real>& law, u32 i, u32 j) {
  const Vec3<real> d = sub3(vec3_of(b.particle_places[j]), vec3_of(b.particle_places[i]));
  const real distance = length3(d), overlap = real(2) * law.radius - distance;
  if (!(overlap > real(0)) || !(distance > real(0))) return {};  // two in one place have no direction
  const u32 body_i = b.particle_bodies[i], body_j = b.particle_bodies[j];
  const Vec3<real> n = scale3(real(1) / distance, d);
  const real lever = real(0.5) * distance;
  const Vec3<real> arm = scale3(lever, n);
  const Vec3<real> here = add3(vec3_of(b.particle_velocities[i]), cross3(vec3(b.motions[body_i].w), arm));
  const Vec3<real> there =
      add3(vec3_of(b.particle_velocities[j]), cross3(vec3(b.motions[body_j].w), scale3(-lever, n)));
  return push_of(law, n, overlap, arm, sub3(there, here),
                 real(1) / (b.particle_shares[body_i] + b.particle_shares[body_j]));
}

template <class real>
void push_particles(Buffers<real>& b, const StepParams<real>&) {
  if (step_is_void(b.counters)) return;
  for (u32 i = 0; i < b.particle_bodies.size(); ++i) {
    const BodyInfo& info = b.body_infos[b.particle_bodies[i]];
    const ParticleLaw<real>& law = b.particle_laws[info.world];
    Push<real> sum = {};
    const auto add = [&](const Push<real>& push) {
      sum.force = add3(sum.force, push.force);
      sum.moment = add3(sum.moment, push.moment);
    };
    if (info.kind == BODY_DYNAMIC) {
      const WorldRange& world = b.world_ranges[info.world];
      for (u32 k = 0; k < world.plane_count; ++k) add(push_of_plane(b, law, i, world.first_plane + k));
      for (u32 k = b.neighbour_starts[i]; k < b.neighbour_starts[i + 1]; ++k)
        add(push_of_neighbour(b, law, i, b.neighbours[k]));
    }
    b.particle_forces[i] = vec4_of(sum.force, real(0));
    b.particle_moments[i] = vec4_of(sum.moment, real(0));
  }
}

}  // namespace lockstep::reference
