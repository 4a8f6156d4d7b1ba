#include <algorithm>
#include <bit>
#include <utility>

#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

// How a sort is shared out. A CPU's core has a cache for the counts of a wide digit, and passes cost it most; a chunk
// is long beside its counts. Elsewhere a chunk is what a work-group takes, and as long as its counts.
struct SortShape {
  u32 most_digit_bits, shortest_chunk, most_chunks;  // NONE: as many as there are
};
constexpr SortShape cpu_sort = {std::bit_width(SORT_DIGITS) - 1, 2 * SORT_DIGITS, 256};
constexpr SortShape gpu_sort = {std::bit_width(CHUNK) - 1, CHUNK, NONE};

const SortShape& sort_shape(const LaunchPlan& plan) { return plan.lanes > 1 ? cpu_sort : gpu_sort; }

}  // namespace

u32 Launcher::sort_passes(u32 bits) const {
  const u32 most = sort_shape(plan()).most_digit_bits;
  return (bits + most - 1) / most;
}

SortArrays Launcher::sort(SortArrays arrays, u32 count, u32 bits) {
  if (count < 2 || bits == 0) return arrays;
  const SortShape& shape = sort_shape(plan());
  const u32 passes = sort_passes(bits), digit_bits = (bits + passes - 1) / passes, digits = 1u << digit_bits;
  const u32 chunk = std::max((count - 1) / shape.most_chunks + 1, shape.shortest_chunk);
  const u32 chunks = (count + chunk - 1) / chunk;
  scratch("radix_counts", std::size_t{digits} * chunks);
  for (u32 pass = 0; pass < passes; ++pass) {
    const u32 shift = pass * digit_bits;
    run_chunks("radix_count", chunks,
               {{"keys", arrays.keys}, {"count", count}, {"shift", shift}, {"digits", digits}, {"chunk", chunk}});
    scan("radix_counts", digits * chunks);
    run_chunks("radix_scatter", chunks,
               {{"keys", arrays.keys},
                {"values", arrays.values},
                {"sorted_keys", arrays.spare_keys},
                {"sorted_values", arrays.spare_values},
                {"count", count},
                {"shift", shift},
                {"digits", digits},
                {"chunk", chunk}});
    std::swap(arrays.keys, arrays.spare_keys);
    std::swap(arrays.values, arrays.spare_values);
  }
  return arrays;
}

}  // namespace lockstep
