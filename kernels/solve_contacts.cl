#pragma OPENCL FP_CONTRACT OFF
// Sweeps of blocked Gauss-Seidel over the colours (cpu_reference/solve_contacts.hpp).
#include "common.h"
#include "types.h"
#include "visit_contact.h"

// One colour of a sweep.
kernel void solve_color(const u32 color, global const u32* color_starts, global const BlockBodies* block_bodies,
                        global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                        global const SoftnessBlock* softness_blocks, global ImpulseBlock* impulse_blocks,
                        global Motion* motions, global const u32* counters) {
  if (STEP_IS_VOID(counters)) return;
  const u32 begin = color_starts[color], items = (color_starts[color + 1u] - begin) * ITEMS_PER_BLOCK;
  FOR_EACH(item, items) {
    const u32 block = begin + item / ITEMS_PER_BLOCK;
    visit_pairs(VISIT_SOLVE, item % ITEMS_PER_BLOCK * LANES, block_bodies + block, block_rows[block], contact_blocks,
                softness_blocks, impulse_blocks, motions);
  }
}

// One work-group: `sweeps` sweeps over the colours from `first_color` on and the overflow.
kernel void solve_tail(const u32 first_color, const u32 sweeps, global const u32* color_starts,
                       global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                       global const ContactBlock* contact_blocks, global const SoftnessBlock* softness_blocks,
                       global ImpulseBlock* impulse_blocks, global Motion* motions, global const u32* counters) {
  const u32 phases = contact_phases(counters);
  for (u32 sweep = 0u; sweep < sweeps; ++sweep) {
    for (u32 phase = min(first_color, counters[COUNTER_COLORS]); phase < phases; ++phase) {
      const u32 begin = phase_begin(phase, color_starts, counters);
      const u32 items = (phase_end(phase, color_starts, counters) - begin) * ITEMS_PER_BLOCK;
      for (u32 item = (u32)get_local_id(0); item < items; item += (u32)get_local_size(0)) {
        const u32 block = begin + item / ITEMS_PER_BLOCK;
        visit_pairs(VISIT_SOLVE, item % ITEMS_PER_BLOCK * LANES, block_bodies + block, block_rows[block],
                    contact_blocks, softness_blocks, impulse_blocks, motions);
      }
      barrier(CLK_GLOBAL_MEM_FENCE);
    }
  }
}
