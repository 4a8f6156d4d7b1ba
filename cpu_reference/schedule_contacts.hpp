// In which order the pairs of each cell are solved (Harada 2011): in batches of at most PACK pairs that share no
// movable body, which are solved at once. A batch becomes a block (cpu_reference/pack_contacts.hpp).
//
// First fit: one pair after another, those with most points first and of equal ones the first in the list, takes its
// slot in the first batch that has room for it and none of its bodies. It is the same to fill one batch after another
// with the first pairs that fit: what work-groups do (kernels/schedule_contacts.cl). A pair that fits into none of
// CELL_BATCHES, as of a body with more pairs, is in no cell.
#pragma once

#include <algorithm>
#include <bit>
#include <map>

#include "cpu_reference/pair_contacts.hpp"

namespace lockstep::reference {

/// Writes the slot of each pair, batch * PACK + lane, and where the blocks of each cell and their rows begin; a block
/// has as many rows as its first pair has points.
template <class real>
void schedule_contacts(Buffers<real>& b, const StepParams<real>&) {
  std::fill(b.cell_slots.begin(), b.cell_slots.end(), NONE);
  const std::size_t cells = b.cell_starts.size() - 1;
  u32 block = 0, row = 0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    b.cell_blocks[cell] = block;
    b.cell_rows[cell] = row;
    std::map<u32, std::uint64_t> batches_of;  // a movable body, as bits
    std::uint64_t full = 0;
    u32 sizes[CELL_BATCHES] = {};
    for (u32 points = MANIFOLD_POINTS; points > 0; --points) {
      for (u32 k = b.cell_starts[cell]; k < b.cell_starts[cell + 1]; ++k) {
        const u32 i = b.cell_pairs[k];
        if (pair_contact_count(b, i) != points) continue;
        std::uint64_t taken = full;
        for (const u32 body : {b.contacts[i].body_a, b.contacts[i].body_b})
          if (b.body_infos[body].kind == BODY_DYNAMIC) taken |= batches_of[body];
        const u32 batch = static_cast<u32>(std::countr_one(taken));
        if (batch == CELL_BATCHES) continue;
        for (const u32 body : {b.contacts[i].body_a, b.contacts[i].body_b})
          batches_of[body] |= std::uint64_t{1} << batch;
        if (sizes[batch] == 0) ++block, row += points;
        b.cell_slots[i] = batch * PACK + sizes[batch]++;
        if (sizes[batch] == PACK) full |= std::uint64_t{1} << batch;
      }
    }
  }
  b.cell_blocks[cells] = block;
  b.cell_rows[cells] = row;
}

}  // namespace lockstep::reference
