#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "types.h"

// Exclusive prefix sums of u32 words, in place: sums of chunks, their scan in one work-group, and the chunks from
// there.

// Work-items of the one work-group that share a scan.
#define SCAN_PARTS 256u

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

kernel void scan_sum(global const u32* values, global u32* scan_sums, global const u32* counters, const u32 count,
                     const u32 counter) {
  const u32 length = scan_length(counters, count, counter);
  FOR_EACH(chunk, (length + CHUNK - 1u) / CHUNK) {
    const u32 begin = chunk * CHUNK;
    scan_sums[chunk] = scan_range_sum(values, begin, scan_end(begin, CHUNK, length));
  }
}

kernel void scan_apply(global u32* values, global const u32* scan_sums, global const u32* counters, const u32 count,
                       const u32 counter) {
  const u32 length = scan_length(counters, count, counter);
  FOR_EACH(chunk, (length + CHUNK - 1u) / CHUNK) {
    const u32 begin = chunk * CHUNK;
    scan_range(values, begin, scan_end(begin, CHUNK, length), scan_sums[chunk]);
  }
}

// One work-group. A word of `values` stands for `width` words of the array that counters speak of.
kernel void scan_group(global u32* values, global const u32* counters, const u32 count, const u32 counter,
                       const u32 width) {
  local u32 sums[SCAN_PARTS];
  const u32 length = (scan_length(counters, count, counter) + width - 1u) / width;
  const u32 parts = (u32)get_local_size(0) < SCAN_PARTS ? (u32)get_local_size(0) : SCAN_PARTS;
  const u32 step = (length + parts - 1u) / parts;
  const u32 part = (u32)get_local_id(0);
  const u32 begin = part < parts ? part * step : length;
  const u32 end = scan_end(begin, step, length);
  if (part < parts) sums[part] = scan_range_sum(values, begin, end);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (part == 0u) {
    u32 sum = 0u;
    for (u32 k = 0u; k < parts; ++k) {
      const u32 value = sums[k];
      sums[k] = sum;
      sum += value;
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (part < parts) scan_range(values, begin, end, sums[part]);
}
