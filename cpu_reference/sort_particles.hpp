// Puts the particles into a hashed uniform grid (Teschner et al. 2003, as in sort_cells): sorted by bucket, those of a
// bucket in order of their indices. A bucket takes as many as there are.
#pragma once

#include <algorithm>

#include "cpu_reference/particle.hpp"

namespace lockstep::reference {

/// Particles that are too far out have no bucket, stand at the end of the list and raise STATUS_OUT_OF_GRID.
template <class real>
void sort_particles(Buffers<real>& b, const StepParams<real>& params) {
  const real size = cell_size<real>(b.counters[COUNTER_MAX_EXTENT]);
  std::vector<u32> ends(params.buckets + 1, 0);  // of the buckets, and of what has none
  const auto bucket = [&](u32 i) { return std::min(b.particle_cells[i].bucket, params.buckets); };
  for (u32 i = 0; i < b.particle_positions.size(); ++i) {
    const Vec3<real> x = vec3_of(b.particle_positions[i]);
    const u32 body = b.particle_bodies[i];
    b.particle_cells[i] = {0, 0, 0, NONE};
    if (in_grid(x.x, size) && in_grid(x.y, size) && in_grid(x.z, size)) {
      const i32 cx = cell_of(x.x, size), cy = cell_of(x.y, size), cz = cell_of(x.z, size);
      b.particle_cells[i] = {cx, cy, cz, bucket_of(cx, row_hash(cy, cz, b.body_infos[body].world), params.buckets)};
    } else {
      b.counters[COUNTER_STATUS] |= STATUS_OUT_OF_GRID;
      b.counters[COUNTER_BAD_BODY] = std::max(b.counters[COUNTER_BAD_BODY], NONE - body);
    }
    ++ends[bucket(i)];
  }
  u32 sum = 0;
  for (u32 k = 0; k <= params.buckets; ++k) {
    b.particle_starts[k] = sum;
    sum += ends[k];
    ends[k] = b.particle_starts[k];
  }
  for (u32 i = 0; i < b.particle_positions.size(); ++i) b.particle_items[ends[bucket(i)]++] = i;
}

}  // namespace lockstep::reference
