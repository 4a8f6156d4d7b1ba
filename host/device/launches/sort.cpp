#include <algorithm>
#include <bit>
#include <utility>

#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

// Digits that a work-item counts in its own memory.
constexpr u32 most_digit_bits = std::bit_width(SORT_DIGITS) - 1;

// A chunk is long beside its counts, and there are chunks for many cores.
constexpr u32 shortest_chunk = 2 * SORT_DIGITS, most_chunks = 256;

}  // namespace

u32 sort_passes(u32 bits) { return (bits + most_digit_bits - 1) / most_digit_bits; }

SortArrays Launcher::sort(SortArrays arrays, u32 count, u32 bits) {
  if (count < 2 || bits == 0) return arrays;
  const u32 passes = sort_passes(bits), digit_bits = (bits + passes - 1) / passes, digits = 1u << digit_bits;
  const u32 chunk = std::max((count + most_chunks - 1) / most_chunks, shortest_chunk);
  const u32 chunks = (count + chunk - 1) / chunk;
  scratch("radix_counts", std::size_t{digits} * chunks);
  for (u32 pass = 0; pass < passes; ++pass) {
    const u32 shift = pass * digit_bits;
    run("radix_count", chunks,
        {{"keys", arrays.keys}, {"count", count}, {"shift", shift}, {"digits", digits}, {"chunk", chunk}});
    scan("radix_counts", digits * chunks);
    run("radix_place", chunks,
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
