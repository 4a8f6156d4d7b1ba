#pragma OPENCL FP_CONTRACT OFF
// Spreads the friction and the twist of each pair that shares one friction patch over its contacts
// (cpu_reference/spread_patches.hpp).
#include "common.h"
#include "spread_patch.h"
#include "types.h"

kernel void spread_patches(global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                           global const ContactBlock* contact_blocks, global const PatchBlock* patch_blocks,
                           global const PatchImpulse* patch_impulses, global ImpulseBlock* impulse_blocks,
                           global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(item, counters[COUNTER_BLOCKS] * ITEMS_PER_BLOCK) {
    const u32 block = item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
    const BlockRows rows = block_rows[block];
    const lane_u32 count = LANE_LOAD_U32(block_bodies[block].count + first);
    global const ContactBlock* contacts = contact_blocks + rows.first;
    global ImpulseBlock* impulses = impulse_blocks + rows.first;
    const LaneSpread spread =
        spread_of(first, rows.count, count, contacts, impulses, patch_blocks + block, patch_impulses + block);
    for (u32 k = 0u; k < rows.count; ++k) {
      const LaneCone r = spread_to(&spread, first, contacts + k, LANE_LOAD(impulses[k].normal + first));
      const lane_mask there = LANE_MASK(count > (lane_u32)k);
      LANE_STORE(there ? r.tangent_1 : LANE_LOAD(impulses[k].tangent_1 + first), impulses[k].tangent_1 + first);
      LANE_STORE(there ? r.tangent_2 : LANE_LOAD(impulses[k].tangent_2 + first), impulses[k].tangent_2 + first);
    }
  }
}
