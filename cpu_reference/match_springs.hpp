// Springs along the surfaces go on from the last step: a particle and what may touch it begin with the stretch that
// they ended it with.
#pragma once

#include <algorithm>
#include <tuple>

#include "cpu_reference/rigid_body.hpp"

namespace lockstep::reference {

/// What was not near begins with none. The springs are in the order of the neighbours.
template <class real>
void match_springs(Buffers<real>& b, const StepParams<real>&) {
  if (step_aborted(b.counters)) return;
  const auto before = [](const SpringKey& a, const SpringKey& c) {
    return std::tie(a.particle, a.partner) < std::tie(c.particle, c.partner);
  };
  const auto end = b.spring_keys.begin() + b.spring_count[0];
  for (u32 i = 0; i < b.particle_bodies.size(); ++i) {
    for (u32 k = b.neighbour_starts[i]; k < b.neighbour_starts[i + 1]; ++k) {
      const SpringKey wanted = {i, b.neighbours[k]};
      const auto key = std::lower_bound(b.spring_keys.begin(), end, wanted, before);
      const bool known = key != end && key->particle == wanted.particle && key->partner == wanted.partner;
      b.stretches[k] = known ? b.spring_stretches[key - b.spring_keys.begin()] : Vec4<real>{0, 0, 0, 0};
    }
  }
}

}  // namespace lockstep::reference
