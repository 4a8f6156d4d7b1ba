// The list of pairs that the searches of the broad phase make, whatever they search in.
#pragma once

#include "cpu_reference/shape_trees.hpp"

namespace lockstep::reference {

/// Makes the list of pairs, ordered by (shape_a, shape_b): those of top-level shapes with each other, with the planes,
/// and with the shapes of trees. `search(k, me, found)` appends the top-level shapes of larger index that `me`, the
/// k-th of them, is paired with, and says whether it takes part at all. Where pairs are more than the capacity none is
/// kept, and the step is aborted.
template <class real, class Search>
void list_pairs(Buffers<real>& b, const StepParams<real>& params, Search&& search) {
  std::vector<Pair> pairs;
  std::vector<u32> found;
  for (u32 k = 0; k < top_level_count(params); ++k) {
    const Bounded<real> me = top_level(b, k);
    found.clear();
    if (!(me.bound.extent > 0) || !search(k, me, found)) continue;
    const WorldRange& world = b.world_ranges[b.body_infos[b.shape_infos[me.shape].body].world];
    for (u32 n = 0; n < world.plane_count; ++n) {
      const u32 plane = b.planes[world.first_plane + n];
      if (is_pair(b, me.shape, plane) && plane_in_range(b, params, me, plane)) found.push_back(plane);
    }
    for (const u32 j : found) pairs.push_back({me.shape, j});
    search_shape_trees(b, params, me, [&](u32 j) { pairs.push_back({std::min(me.shape, j), std::max(me.shape, j)}); });
  }
  std::ranges::sort(pairs, {}, [](const Pair& pair) { return std::pair(pair.shape_a, pair.shape_b); });

  const u32 total = u32(pairs.size());
  std::fill(b.pair_starts.begin(), b.pair_starts.end(), 0u);
  for (const Pair& pair : pairs) ++b.pair_starts[pair.shape_a + 1];
  for (u32 i = 0; i < params.shapes; ++i) b.pair_starts[i + 1] += b.pair_starts[i];
  std::copy_n(pairs.begin(), std::min(total, params.pair_capacity), b.pairs.begin());
  b.counters[COUNTER_PAIRS_NEEDED] = total;
  b.counters[COUNTER_PAIRS] = total <= params.pair_capacity ? total : 0;
  if (total > params.pair_capacity) b.counters[COUNTER_STATUS] |= STATUS_PAIRS_FULL;
}

}  // namespace lockstep::reference
