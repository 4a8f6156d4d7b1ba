// Keeps what the next step starts from: how far each particle is sheared against each of its neighbours.
#pragma once

#include "cpu_reference/rigid_body.hpp"

namespace lockstep::reference {

template <class real>
void store_springs(Buffers<real>& b, const StepParams<real>&) {
  if (step_aborted(b.counters)) return;
  const u32 particles = static_cast<u32>(b.particle_bodies.size());
  b.spring_count[0] = b.neighbour_starts[particles];
  for (u32 i = 0; i < particles; ++i) {
    for (u32 k = b.neighbour_starts[i]; k < b.neighbour_starts[i + 1]; ++k) {
      b.spring_keys[k] = {i, b.neighbours[k]};
      b.spring_stretches[k] = b.stretches[k];
    }
  }
}

}  // namespace lockstep::reference
