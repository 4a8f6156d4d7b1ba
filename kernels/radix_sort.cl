#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "types.h"

// A pass of a stable radix sort from the lowest digit up (Knuth, The Art of Computer Programming 3, 5.2.5): the digits
// of each chunk are counted, the counts are scanned digit by digit, chunk by chunk, and each chunk puts its keys, in
// order, where its counts have come to point to. The order does not depend on the length of the chunks. On a CPU device
// a work-item takes a chunk; elsewhere a work-group does, of CHUNK keys at most, whose digits it has in local memory.

static inline u32 radix_chunk_end(u32 begin, u32 chunk, u32 count) {
  return chunk < count - begin ? begin + chunk : count;
}

static inline u32 radix_digit(u32 key, u32 shift, u32 digits) { return (key >> shift) & (digits - 1u); }

kernel void radix_count(global const u32* keys, global u32* radix_counts, const u32 count, const u32 shift,
                        const u32 digits, const u32 chunk) {
  const u32 chunks = (count + chunk - 1u) / chunk;
#if EACH_TAKES_NEIGHBOURS
  FOR_EACH(c, chunks) {
    u32 counts[SORT_DIGITS];
    for (u32 d = 0u; d < digits; ++d) counts[d] = 0u;
    const u32 begin = c * chunk, end = radix_chunk_end(begin, chunk, count);
    for (u32 i = begin; i < end; ++i) ++counts[radix_digit(keys[i], shift, digits)];
    for (u32 d = 0u; d < digits; ++d) radix_counts[d * chunks + c] = counts[d];
  }
#else
  local u32 counts[SORT_DIGITS];
  FOR_EACH_GROUP(c, chunks) {
    const u32 begin = c * chunk, end = radix_chunk_end(begin, chunk, count);
    FOR_EACH_OF_GROUP(d, digits) { counts[d] = 0u; }
    barrier(CLK_LOCAL_MEM_FENCE);
    FOR_EACH_OF_GROUP(i, end - begin) { atomic_inc(&counts[radix_digit(keys[begin + i], shift, digits)]); }
    barrier(CLK_LOCAL_MEM_FENCE);
    FOR_EACH_OF_GROUP(d, digits) { radix_counts[d * chunks + c] = counts[d]; }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
#endif
}

kernel void radix_scatter(global const u32* keys, global const u32* values, global u32* sorted_keys,
                          global u32* sorted_values, global const u32* radix_counts, const u32 count, const u32 shift,
                          const u32 digits, const u32 chunk) {
  const u32 chunks = (count + chunk - 1u) / chunk;
#if EACH_TAKES_NEIGHBOURS
  FOR_EACH(c, chunks) {
    u32 slots[SORT_DIGITS];
    for (u32 d = 0u; d < digits; ++d) slots[d] = radix_counts[d * chunks + c];
    const u32 begin = c * chunk, end = radix_chunk_end(begin, chunk, count);
    for (u32 i = begin; i < end; ++i) {
      const u32 key = keys[i];
      const u32 slot = slots[radix_digit(key, shift, digits)]++;
      sorted_keys[slot] = key;
      sorted_values[slot] = values[i];
    }
  }
#else
  local u32 chunk_digits[CHUNK];
  FOR_EACH_GROUP(c, chunks) {
    const u32 begin = c * chunk, end = radix_chunk_end(begin, chunk, count);
    FOR_EACH_OF_GROUP(i, end - begin) { chunk_digits[i] = radix_digit(keys[begin + i], shift, digits); }
    barrier(CLK_LOCAL_MEM_FENCE);
    FOR_EACH_OF_GROUP(i, end - begin) {
      const u32 digit = chunk_digits[i];
      u32 slot = radix_counts[digit * chunks + c];  // behind its equals that are before it in the chunk
      for (u32 before = 0u; before < i; ++before) slot += chunk_digits[before] == digit ? 1u : 0u;
      sorted_keys[slot] = keys[begin + i];
      sorted_values[slot] = values[begin + i];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
#endif
}
