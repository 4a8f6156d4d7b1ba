// Where the particles are, and how fast, after a sub-step that another one follows.
#pragma once

#include "cpu_reference/particle.hpp"

namespace lockstep::reference {

template <class real>
void update_particles(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters) || params.substep + 1 == params.substeps) return;
  for (u32 i = 0; i < b.particle_bodies.size(); ++i) update_particle(b, i);
}

}  // namespace lockstep::reference
