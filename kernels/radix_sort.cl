#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "types.h"

// A pass of a stable radix sort from the lowest digit up (Knuth, The Art of Computer Programming 3, 5.2.5): each
// work-item counts the digits of its chunk, the counts are scanned digit by digit, chunk by chunk, and each chunk puts
// its keys, in order, where its counts have come to point to. The order does not depend on the length of the chunks.

static inline u32 radix_chunk_end(u32 begin, u32 chunk, u32 count) {
  return chunk < count - begin ? begin + chunk : count;
}

kernel void radix_count(global const u32* keys, global u32* radix_counts, const u32 count, const u32 shift,
                        const u32 digits, const u32 chunk) {
  const u32 chunks = (count + chunk - 1u) / chunk;
  FOR_EACH(c, chunks) {
    u32 counts[SORT_DIGITS];
    for (u32 d = 0u; d < digits; ++d) counts[d] = 0u;
    const u32 begin = c * chunk, end = radix_chunk_end(begin, chunk, count);
    for (u32 i = begin; i < end; ++i) ++counts[(keys[i] >> shift) & (digits - 1u)];
    for (u32 d = 0u; d < digits; ++d) radix_counts[d * chunks + c] = counts[d];
  }
}

kernel void radix_place(global const u32* keys, global const u32* values, global u32* sorted_keys,
                        global u32* sorted_values, global const u32* radix_counts, const u32 count, const u32 shift,
                        const u32 digits, const u32 chunk) {
  const u32 chunks = (count + chunk - 1u) / chunk;
  FOR_EACH(c, chunks) {
    u32 slots[SORT_DIGITS];
    for (u32 d = 0u; d < digits; ++d) slots[d] = radix_counts[d * chunks + c];
    const u32 begin = c * chunk, end = radix_chunk_end(begin, chunk, count);
    for (u32 i = begin; i < end; ++i) {
      const u32 key = keys[i];
      const u32 slot = slots[(key >> shift) & (digits - 1u)]++;
      sorted_keys[slot] = key;
      sorted_values[slot] = values[i];
    }
  }
}
