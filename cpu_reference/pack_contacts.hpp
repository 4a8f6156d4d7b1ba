// Sorts the pairs in contact by colour and lays them into blocks of PACK lanes.
//
// In a colour those with more points come first, of equal ones the first in the list, and each colour starts a block; a
// pair without a colour gets the first lane of a block of its own. Row k of a block holds the k-th contact of each
// lane, so that a block has as many rows as its first pair has contacts. Lanes that are left over read the null body
// and solve nothing. A pair is `central` where neither body, if it moves, can tell the direction of its arm from the
// normal: isotropic inertia, shape at the centre of mass.
//
// Where pairs are solved in cells, the blocks of these come first, cell by cell: a block for each batch of a schedule
// (cpu_reference/schedule_contacts.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "cpu_reference/math.hpp"
#include "cpu_reference/pair_contacts.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
bool is_central(const Buffers<real>& buffers, u32 body, u32 shape) {
  const BodyInfo& info = buffers.body_infos[body];
  return info.kind != BODY_DYNAMIC ||
         (info.isotropic != 0 && (buffers.shape_infos[shape].flags & SHAPE_IS_CENTRAL) != 0);
}

/// The colour of the pair that contact `i` is the first of. Where bodies are split, pairs may share them, and all are
/// laid out as one colour.
template <class real>
u32 color_of_pair(const Buffers<real>& buffers, u32 i) {
  return buffers.body_copy_blocks.empty() ? buffers.contact_colors[i] : 0;
}

/// Pairs that are laid out by colour; not those with a slot in a cell.
template <class real>
bool has_color(const Buffers<real>& buffers, u32 i) {
  return buffers.cell_slots.empty() || buffers.cell_slots[i] == NONE;
}

/// The slots of the pairs that have a slot in a cell, by their first contacts.
template <class real>
std::vector<u32> slots_in_cells(const Buffers<real>& b) {
  std::vector<u32> slots(b.cell_slots.size(), NONE);
  for (std::size_t cell = 0; cell + 1 < b.cell_starts.size(); ++cell) {
    for (u32 k = b.cell_starts[cell]; k < b.cell_starts[cell + 1]; ++k) {
      const u32 i = b.cell_pairs[k];
      if (b.cell_slots[i] != NONE) slots[i] = b.cell_blocks[cell] * PACK + b.cell_slots[i];
    }
  }
  return slots;
}

/// Numbers by colour and number of points.
using PackTable = std::array<std::array<u32, MANIFOLD_POINTS + 1>, MAX_COLORS + 1>;

/// Lanes from one pair to the next.
inline u32 pack_stride(u32 color) { return color == MAX_COLORS ? PACK : 1; }

/// Where each colour starts, and what counts tell of it; returns the first slot of each sort of pairs.
template <class real>
PackTable pack_lay_out(Buffers<real>& buffers, const StepParams<real>& params, const PackTable& sizes) {
  auto& counters = buffers.counters;
  PackTable first_slots = {};
  u32 block = buffers.cell_blocks.empty() ? 0 : buffers.cell_blocks.back();
  u32 rows = buffers.cell_rows.empty() ? 0 : buffers.cell_rows.back();
  u32 colors = 0, large_colors = 0;
  for (u32 color = 0; color <= MAX_COLORS; ++color) {
    buffers.color_starts[color] = block;
    u32 slot = block * PACK;
    for (u32 points = MANIFOLD_POINTS; points > 0; --points) {
      first_slots[color][points] = slot;
      for (u32 i = 0; i < sizes[color][points]; ++i, slot += pack_stride(color)) rows += slot % PACK == 0 ? points : 0;
    }
    const u32 size = (slot + PACK - 1) / PACK - block;
    block += size;
    if (color == MAX_COLORS) counters[COUNTER_OVERFLOW] = size;
    if (color < MAX_COLORS && size > 0) colors = color + 1;
    if (color < MAX_COLORS && size >= LARGE_COLOR) large_colors = color + 1;
  }
  buffers.color_starts[MAX_COLORS + 1] = block;

  counters[COUNTER_COLORS] = colors;
  counters[COUNTER_LARGE_COLORS] = large_colors;
  counters[COUNTER_BLOCKS_NEEDED] = block;
  counters[COUNTER_BLOCKS] = std::min(block, params.block_capacity);
  counters[COUNTER_ROWS_NEEDED] = rows;
  counters[COUNTER_ROWS] = std::min(rows, params.row_capacity);
  if (block > params.block_capacity) counters[COUNTER_STATUS] |= STATUS_BLOCKS_FULL;
  if (rows > params.row_capacity) counters[COUNTER_STATUS] |= STATUS_ROWS_FULL;
  return first_slots;
}

template <class real>
void pack_contacts(Buffers<real>& buffers, const StepParams<real>& params) {
  const u32 contact_count = buffers.counters[COUNTER_CONTACTS];
  PackTable sizes = {};
  for (u32 i = 0; i < contact_count; ++i) {
    const u32 count = pair_contact_count(buffers, i);
    if (count > 0 && has_color(buffers, i)) ++sizes[color_of_pair(buffers, i)][count];
  }
  PackTable slots = pack_lay_out(buffers, params, sizes);

  const std::vector<u32> in_cells = slots_in_cells(buffers);
  const auto next_slot = [&](u32 i, u32 count) {
    if (!has_color(buffers, i)) return in_cells[i];
    const u32 color = color_of_pair(buffers, i), slot = slots[color][count];
    slots[color][count] += pack_stride(color);
    return slot;
  };

  const u32 blocks = buffers.counters[COUNTER_BLOCKS];
  for (u32 block = 0; block < blocks; ++block) {
    BlockBodies& bodies = buffers.block_bodies[block];
    std::fill_n(bodies.body_a, PACK, params.bodies);
    std::fill_n(bodies.body_b, PACK, params.bodies);
    std::fill_n(bodies.kind, PACK, u32{BLOCK_PADDING});
    std::fill_n(bodies.contact, PACK, NONE);
    std::fill_n(bodies.count, PACK, 0u);
  }

  for (u32 i = 0; i < contact_count; ++i) {
    const u32 count = pair_contact_count(buffers, i);
    if (count == 0) continue;
    const u32 slot = next_slot(i, count);
    if (slot / PACK >= blocks) {
      std::fill_n(buffers.contact_slots.begin() + i, count, NONE);
      continue;
    }
    const Contact& contact = buffers.contacts[i];
    const bool central =
        is_central(buffers, contact.body_a, contact.shape_a) && is_central(buffers, contact.body_b, contact.shape_b);
    BlockBodies& bodies = buffers.block_bodies[slot / PACK];
    bodies.body_a[slot % PACK] = contact.body_a;
    bodies.body_b[slot % PACK] = contact.body_b;
    bodies.kind[slot % PACK] = central ? BLOCK_CENTRAL : BLOCK_GENERAL;
    bodies.contact[slot % PACK] = i;
    bodies.count[slot % PACK] = count;
  }

  u32 row = 0;
  for (u32 block = 0; block < blocks; ++block) {
    const BlockBodies& bodies = buffers.block_bodies[block];
    buffers.block_rows[block] = {row, bodies.count[0]};
    for (u32 lane = 0; lane < PACK; ++lane) {
      for (u32 k = 0; k < bodies.count[lane]; ++k)
        buffers.contact_slots[bodies.contact[lane] + k] = (row + k) * PACK + lane;
    }
    row += bodies.count[0];
  }
}

}  // namespace lockstep::reference
