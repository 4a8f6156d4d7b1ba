#pragma OPENCL FP_CONTRACT OFF
// Gives the bodies the impulses that the contacts start from (cpu_reference/warm_start.hpp).
#include "common.h"
#include "types.h"
#include "visit_contact.h"

kernel void warm_color(const u32 color, global const u32* color_starts, global const BlockBodies* block_bodies,
                       global const ContactBlock* contact_blocks, global const ImpulseBlock* impulse_blocks,
                       global Motion* motions, global const u32* counters) {
  if (STEP_IS_VOID(counters)) return;
  const u32 begin = color_starts[color], rows = (color_starts[color + 1u] - begin) * ROWS_PER_BLOCK;
  FOR_EACH(row, rows) {
    const u32 block = begin + row / ROWS_PER_BLOCK;
    start_contacts(row % ROWS_PER_BLOCK * LANES, block_bodies + block, contact_blocks + block, impulse_blocks + block,
                   motions);
  }
}

// One work-group: the colours from `first_color` on and the overflow.
kernel void warm_tail(const u32 first_color, global const u32* color_starts, global const BlockBodies* block_bodies,
                      global const ContactBlock* contact_blocks, global const ImpulseBlock* impulse_blocks,
                      global Motion* motions, global const u32* counters) {
  const u32 phases = contact_phases(counters);
  for (u32 phase = min(first_color, counters[COUNTER_COLORS]); phase < phases; ++phase) {
    const u32 begin = phase_begin(phase, color_starts, counters);
    const u32 rows = (phase_end(phase, color_starts, counters) - begin) * ROWS_PER_BLOCK;
    for (u32 row = (u32)get_local_id(0); row < rows; row += (u32)get_local_size(0)) {
      const u32 block = begin + row / ROWS_PER_BLOCK;
      start_contacts(row % ROWS_PER_BLOCK * LANES, block_bodies + block, contact_blocks + block, impulse_blocks + block,
                     motions);
    }
    barrier(CLK_GLOBAL_MEM_FENCE);
  }
}
