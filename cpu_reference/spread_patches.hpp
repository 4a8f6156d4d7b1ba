// After the last sub-step, spreads the friction and the twist of each pair that shares one friction patch over its
// contacts (spread_patch.hpp): what the next step starts from, and what the report holds against the model of a cone
// for each contact.
#pragma once

#include "cpu_reference/spread_patch.hpp"

namespace lockstep::reference {

template <class real>
void spread_patches(Buffers<real>& buffers, const StepParams<real>&) {
  if (step_aborted(buffers.counters)) return;
  for (u32 block = 0; block < buffers.counters[COUNTER_BLOCKS]; ++block) {
    for (u32 lane = 0; lane < PACK; ++lane) {
      const u32 first = buffers.block_rows[block].first, count = buffers.block_bodies[block].count[lane];
      if (count == 0) continue;
      const PatchSpread<real> spread = spread_of(buffers.contact_blocks, buffers.impulse_blocks, first, count, lane,
                                                 buffers.patch_blocks[block], buffers.patch_impulses[block]);
      for (u32 row = first; row < first + count; ++row) {
        ImpulseBlock<real>& impulses = buffers.impulse_blocks[row];
        const ConeVector<real> r = spread_to(spread, buffers.contact_blocks[row], lane, impulses.normal[lane]);
        impulses.tangent_1[lane] = r.tangent_1;
        impulses.tangent_2[lane] = r.tangent_2;
      }
    }
  }
}

}  // namespace lockstep::reference
