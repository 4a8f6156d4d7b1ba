// Where each shape is that the broad phase looks at (cpu_reference/shape_bound.hpp): those of trees are not among them.
#pragma once

#include "cpu_reference/shape_bound.hpp"
#include "cpu_reference/top_level_shapes.hpp"

namespace lockstep::reference {

/// Planes have extent 0 and stay out of the search; so does a shape that has no finite position, which raises
/// STATUS_OUT_OF_GRID.
template <class real>
void update_bounds(Buffers<real>& b, const StepParams<real>& params) {
  for (u32 k = 0; k < top_level_count(params); ++k) {
    const u32 i = top_level_shape(b, k);
    const bool finite = shape_bound(b, params, i, b.bounds[k]);
    const real extent = b.bounds[k].extent;
    note_extent(finite, extent, b.shape_infos[i].body, b.counters);
  }
}

}  // namespace lockstep::reference
