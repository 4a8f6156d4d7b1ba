// Broad phase on a hashed uniform grid (Teschner et al. 2003): pairs of shapes that can touch within the step
// (cpu_reference/pair_test.hpp). Each looks into the cells that hold the centres of all that it could be paired with.
#pragma once

#include "cpu_reference/list_pairs.hpp"

namespace lockstep::reference {

/// The top-level shapes of larger index that this one is paired with.
template <class real>
void search_grid(const Buffers<real>& b, const StepParams<real>& params, const Bounded<real>& me,
                 std::vector<u32>& found) {
  const u32 max_extent = b.counters[COUNTER_MAX_EXTENT];
  const real size = cell_size<real>(max_extent);
  const real range = pair_range(me.bound.extent, max_extent);
  const Vec3<real> center = me.center();
  const u32 world = b.body_infos[b.shape_infos[me.shape].body].world;
  const i32 low_x = cell_of(center.x - range, size), high_x = cell_of(center.x + range, size);
  const i32 low_y = cell_of(center.y - range, size), high_y = cell_of(center.y + range, size);
  const i32 low_z = cell_of(center.z - range, size), high_z = cell_of(center.z + range, size);
  for (i32 z = low_z; z <= high_z; ++z) {
    for (i32 y = low_y; y <= high_y; ++y) {
      for (i32 x = low_x; x <= high_x; ++x) {
        const u32 bucket = bucket_of(x, row_hash(y, z, world), params.buckets);
        for (u32 slot = b.bucket_starts[bucket]; slot < b.bucket_starts[bucket + 1]; ++slot) {
          const u32 k = b.bucket_items[slot];
          const Bounded<real> other = top_level(b, k);
          const bool in_cell = b.cells[k].x == x && b.cells[k].y == y && b.cells[k].z == z;
          if (other.shape > me.shape && in_cell && are_pair(b, params, me, other)) found.push_back(other.shape);
        }
      }
    }
  }
}

template <class real>
void find_pairs(Buffers<real>& b, const StepParams<real>& params) {
  list_pairs(b, params, [&](u32 k, const Bounded<real>& me, std::vector<u32>& found) {
    const bool has_cell = b.cells[k].bucket != NONE;
    if (has_cell) search_grid(b, params, me, found);
    return has_cell;
  });
}

}  // namespace lockstep::reference
