// Broad phase on a hashed uniform grid (Teschner et al. 2003): pairs of shapes that can touch within the step
// (cpu_reference/pair_test.hpp). Each looks into the cells that hold the centres of all that it could be paired with.
#pragma once

#include "cpu_reference/pair_test.hpp"

namespace lockstep::reference {

/// The bounded shapes of larger index that shape i is paired with.
template <class real>
void search_grid(const Buffers<real>& b, const StepParams<real>& params, u32 i, std::vector<u32>& found) {
  const u32 max_extent = b.counters[COUNTER_MAX_EXTENT];
  const real size = cell_size(params, max_extent);
  const real reach = pair_reach(params, b.bounds[i].extent, max_extent);
  const Vec3<real> center = bound_center(b, i);
  const u32 world = b.body_infos[b.shape_infos[i].body].world;
  const i32 low_x = cell_of(center.x - reach, size), high_x = cell_of(center.x + reach, size);
  const i32 low_y = cell_of(center.y - reach, size), high_y = cell_of(center.y + reach, size);
  const i32 low_z = cell_of(center.z - reach, size), high_z = cell_of(center.z + reach, size);
  for (i32 z = low_z; z <= high_z; ++z) {
    for (i32 y = low_y; y <= high_y; ++y) {
      for (i32 x = low_x; x <= high_x; ++x) {
        const u32 bucket = bucket_of(x, row_hash(y, z, world), params.buckets);
        for (u32 k = b.bucket_starts[bucket]; k < b.bucket_starts[bucket + 1]; ++k) {
          const u32 j = b.bucket_items[k];
          const bool in_cell = b.cells[j].x == x && b.cells[j].y == y && b.cells[j].z == z;
          if (j > i && in_cell && is_pair(b, i, j) && shapes_in_reach(b, params, i, j)) found.push_back(j);
        }
      }
    }
  }
}

template <class real>
void find_pairs(Buffers<real>& b, const StepParams<real>& params) {
  list_pairs(b, params, [&](u32 i, std::vector<u32>& found) {
    const bool has_cell = b.cells[i].bucket != NONE;
    if (has_cell) search_grid(b, params, i, found);
    return has_cell;
  });
}

}  // namespace lockstep::reference
