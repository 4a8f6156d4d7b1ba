#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "types.h"

// Exclusive prefix sums of u32 words, in place: sums of chunks, their scan in one work-group, and the chunks from
// there. On a CPU device a work-item takes a chunk, elsewhere a work-group does, so that neighbours read together.

// Work-items of the one work-group that share a scan.
#define SCAN_CHUNKS 256u

// `counter` is NONE, or the counter that says on the device how many words there are (and one more, for the total).
static inline u32 scan_length(global const u32* counters, u32 count, u32 counter) {
  if (counter == NONE) return count;
  const u32 known = counters[counter] + 1u;
  return known < count ? known : count;
}

static inline u32 scan_range_sum(global const u32* values, u32 begin, u32 end) {
  u32 sum = 0u;
  for (u32 i = begin; i < end; ++i) sum += values[i];
  return sum;
}

// Replaces words by the sums of what is before them.
static inline void scan_range(global u32* values, u32 begin, u32 end, u32 sum) {
  for (u32 i = begin; i < end; ++i) {
    const u32 value = values[i];
    values[i] = sum;
    sum += value;
  }
}

static inline u32 scan_end(u32 begin, u32 step, u32 length) {
  return begin < length && step < length - begin ? begin + step : length;
}

// Of the words of a chunk; one that is no longer there counts 0.
static inline u32 scan_word(global const u32* values, u32 i, u32 length) { return i < length ? values[i] : 0u; }

kernel void scan_sum(global const u32* values, global u32* scan_sums, global const u32* counters, const u32 count,
                     const u32 counter) {
  const u32 length = scan_length(counters, count, counter), chunks = (length + CHUNK - 1u) / CHUNK;
#if EACH_TAKES_NEIGHBOURS
  FOR_EACH(chunk, chunks) {
    const u32 begin = chunk * CHUNK;
    scan_sums[chunk] = scan_range_sum(values, begin, scan_end(begin, CHUNK, length));
  }
#else
  local u32 sums[CHUNK];
  FOR_EACH_GROUP(chunk, chunks) {
    FOR_EACH_OF_GROUP(i, CHUNK) { sums[i] = scan_word(values, chunk * CHUNK + i, length); }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (u32 width = CHUNK / 2u; width > 0u; width /= 2u) {
      FOR_EACH_OF_GROUP(i, width) { sums[i] += sums[width + i]; }
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    if (get_local_id(0) == 0) scan_sums[chunk] = sums[0];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
#endif
}

// By a work-group: sums of 1, 2, 4, ... words up to each (Hillis and Steele, Data Parallel Algorithms, 1986).
kernel void scan_apply(global u32* values, global const u32* scan_sums, global const u32* counters, const u32 count,
                       const u32 counter) {
  const u32 length = scan_length(counters, count, counter), chunks = (length + CHUNK - 1u) / CHUNK;
#if EACH_TAKES_NEIGHBOURS
  FOR_EACH(chunk, chunks) {
    const u32 begin = chunk * CHUNK;
    scan_range(values, begin, scan_end(begin, CHUNK, length), scan_sums[chunk]);
  }
#else
  local u32 sums[2u * CHUNK];
  FOR_EACH_GROUP(chunk, chunks) {
    FOR_EACH_OF_GROUP(i, CHUNK) { sums[i] = scan_word(values, chunk * CHUNK + i, length); }
    barrier(CLK_LOCAL_MEM_FENCE);
    u32 from = 0u;
    for (u32 width = 1u; width < CHUNK; width *= 2u) {
      FOR_EACH_OF_GROUP(i, CHUNK) {
        sums[CHUNK - from + i] = sums[from + i] + (i >= width ? sums[from + i - width] : 0u);
      }
      from = CHUNK - from;
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    FOR_EACH_OF_GROUP(i, min(CHUNK, length - chunk * CHUNK)) {
      values[chunk * CHUNK + i] = scan_sums[chunk] + (i > 0u ? sums[from + i - 1u] : 0u);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
#endif
}

// One work-group. A word of `values` stands for `width` words of the array that counters speak of.
kernel void scan_group(global u32* values, global const u32* counters, const u32 count, const u32 counter,
                       const u32 width) {
  local u32 sums[SCAN_CHUNKS];
  const u32 length = (scan_length(counters, count, counter) + width - 1u) / width;
  const u32 chunks = (u32)get_local_size(0) < SCAN_CHUNKS ? (u32)get_local_size(0) : SCAN_CHUNKS;
  const u32 step = (length + chunks - 1u) / chunks;
  const u32 chunk = (u32)get_local_id(0);
  const u32 begin = chunk < chunks ? chunk * step : length;
  const u32 end = scan_end(begin, step, length);
  if (chunk < chunks) sums[chunk] = scan_range_sum(values, begin, end);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (chunk == 0u) {
    u32 sum = 0u;
    for (u32 k = 0u; k < chunks; ++k) {
      const u32 value = sums[k];
      sums[k] = sum;
      sum += value;
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (chunk < chunks) scan_range(values, begin, end, sums[chunk]);
}
