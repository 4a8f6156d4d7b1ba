// Puts the bounded shapes into a hashed uniform grid (Teschner et al., Optimized Spatial Hashing for Collision
// Detection of Deformable Objects, 2003): a counting sort by bucket, top-level shapes in order within a bucket.
#pragma once

#include <algorithm>

#include "cpu_reference/grid.hpp"
#include "cpu_reference/top_level_shapes.hpp"

namespace lockstep::reference {

/// Shapes without a cell (planes, and what is too far out, which raises STATUS_OUT_OF_GRID) have bucket NONE and are in
/// no list; the list's free end is filled with NONE.
template <class real>
void sort_cells(Buffers<real>& b, const StepParams<real>& params) {
  const real size = cell_size<real>(b.counters[COUNTER_MAX_EXTENT]);
  std::fill(b.bucket_starts.begin(), b.bucket_starts.end(), 0u);
  std::fill(b.bucket_items.begin(), b.bucket_items.end(), NONE);

  // count the members of bucket k in entry k + 1
  for (u32 i = 0; i < top_level_count(params); ++i) {
    const Bound<real>& bound = b.bounds[i];
    const u32 body = b.shape_infos[top_level_shape(b, i)].body;
    b.cells[i] = {0, 0, 0, NONE};
    if (!(bound.extent > 0)) continue;
    const Vec3<real> center = vec3(bound.center);
    if (in_grid(center.x, size) && in_grid(center.y, size) && in_grid(center.z, size)) {
      const i32 x = cell_of(center.x, size), y = cell_of(center.y, size), z = cell_of(center.z, size);
      const u32 bucket = bucket_of(x, row_hash(y, z, b.body_infos[body].world), params.buckets);
      b.cells[i] = {x, y, z, bucket};
      ++b.bucket_starts[bucket + 1];
    } else {
      b.counters[COUNTER_STATUS] |= STATUS_OUT_OF_GRID;
      b.counters[COUNTER_BAD_BODY] = std::max(b.counters[COUNTER_BAD_BODY], NONE - body);
    }
  }

  for (u32 k = 0; k < params.buckets; ++k) b.bucket_starts[k + 1] += b.bucket_starts[k];
  std::vector<u32> cursors = b.bucket_starts;
  for (u32 i = 0; i < top_level_count(params); ++i) {
    if (b.cells[i].bucket != NONE) b.bucket_items[cursors[b.cells[i].bucket]++] = i;
  }
}

}  // namespace lockstep::reference
