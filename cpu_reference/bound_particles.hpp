// Where the particles are at the start of a step, and how far one of them can come in it: r + m + h (|v| + |w| |a|) for
// one at the arm a, m its margin. The largest sizes the cells of the grid, as in update_bounds.
#pragma once

#include "cpu_reference/particle.hpp"
#include "cpu_reference/tolerances.hpp"

namespace lockstep::reference {

/// A particle that has no finite position raises STATUS_OUT_OF_GRID.
template <class real>
void bound_particles(Buffers<real>& b, const StepParams<real>& params) {
  const real h = step_length(params);
  for (u32 i = 0; i < b.particle_bodies.size(); ++i) {
    update_particle(b, i);
    const u32 body = b.particle_bodies[i];
    const Motion<real>& motion = b.motions[body];
    const real speed = length3(vec3(motion.v)) + length3(vec3(motion.w)) * length3(vec3_of(b.particle_offsets[i]));
    const real radius = b.particle_laws[b.body_infos[body].world].radius;
    const real extent =
        radius + shape_margin(params, own_margin(params, radius, radius), motion.inverse_mass) + h * speed;
    const Vec3<real> x = vec3_of(b.particle_positions[i]);
    const bool finite = is_finite(x.x) && is_finite(x.y) && is_finite(x.z) && is_finite(extent);
    note_extent(finite, extent, body, b.counters);
  }
}

}  // namespace lockstep::reference
