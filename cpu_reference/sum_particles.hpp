// What the particles of a body add up to: force and torque about the centre of mass, in the order of the particles.
#pragma once

#include "cpu_reference/particle.hpp"

namespace lockstep::reference {

template <class real>
void sum_particles(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;
  for (u32 body = 0; body < params.bodies; ++body) {
    const Quat<real> q = quat(b.orientations[body]);
    Vec3<real> force = {}, torque = {};
    const bool moves = b.body_infos[body].kind == BODY_DYNAMIC;
    for (u32 i = b.body_particles[body]; moves && i < b.body_particles[body + 1]; ++i) {
      const Vec3<real> f = vec3_of(b.particle_forces[i]), arm = rotate3(q, vec3_of(b.particle_offsets[i]));
      force = add3(force, f);
      torque = add3(torque, add3(cross3(arm, f), vec3_of(b.particle_moments[i])));
    }
    b.particle_loads[body] = {{force.x, force.y, force.z}, real(0), {torque.x, torque.y, torque.z}, real(0)};
  }
}

}  // namespace lockstep::reference
