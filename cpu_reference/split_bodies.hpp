// Splits each dynamic body among its pairs in contact, for cpu_reference/body_copies.hpp: counts the pairs of each body
// and gives each side of each pair a slot among the copies of its body. Copies follow one another as the slots of the
// pairs do, so that their sum has one order whatever finds them.
#pragma once

#include <algorithm>
#include <vector>

#include "host/buffers.hpp"

namespace lockstep::reference {

/// Calls function(body, block, lane, is_b) for each side of each slot in order; body is NONE where that cannot move.
template <class real, class Function>
void for_each_side(const Buffers<real>& buffers, u32 body_count, Function&& function) {
  for (u32 slot = 0; slot < buffers.counters[COUNTER_BLOCKS] * PACK; ++slot) {
    const BlockBodies& bodies = buffers.block_bodies[slot / PACK];
    const u32 sides[2] = {bodies.body_a[slot % PACK], bodies.body_b[slot % PACK]};
    for (u32 k = 0; k < 2; ++k) {
      const bool movable = sides[k] < body_count && buffers.body_infos[sides[k]].kind == BODY_DYNAMIC;
      function(movable ? sides[k] : NONE, slot / PACK, slot % PACK, k == 1);
    }
  }
}

template <class real>
void split_bodies(Buffers<real>& buffers, const StepParams<real>& params) {
  auto& starts = buffers.body_copy_starts;
  std::fill(starts.begin(), starts.end(), 0u);
  for_each_side(buffers, params.bodies, [&](u32 body, u32, u32, bool) {
    if (body != NONE) ++starts[body + 1];
  });
  for (u32 i = 0; i < params.bodies; ++i) starts[i + 1] += starts[i];

  std::vector<u32> next(starts.begin(), starts.end());
  for_each_side(buffers, params.bodies, [&](u32 body, u32 block, u32 lane, bool is_b) {
    BodyCopyBlock<real>& out = buffers.body_copy_blocks[block];
    (is_b ? out.copies_b : out.copies_a)[lane] = body != NONE ? real(starts[body + 1] - starts[body]) : real(0);
    (is_b ? out.slot_b : out.slot_a)[lane] = body != NONE ? next[body]++ : NONE;
  });
}

}  // namespace lockstep::reference
