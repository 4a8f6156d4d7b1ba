// Sorts the contacts by colour and lays them into blocks of PACK lanes.
//
// In a colour they stand by index, and each colour starts a block; a contact without a colour gets the first lane of a
// block of its own. Lanes that are left over read the null body and solve nothing. A contact is `central` where neither
// body, if it moves, can tell the direction of its arm from the normal: isotropic inertia, shape at the centre of mass.
#pragma once

#include <algorithm>
#include <array>

#include "cpu_reference/math.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
bool is_central(const Buffers<real>& buffers, u32 body, u32 shape) {
  const BodyInfo& info = buffers.body_infos[body];
  return info.kind != BODY_DYNAMIC ||
         (info.isotropic != 0 && (buffers.shape_infos[shape].flags & SHAPE_IS_CENTRAL) != 0);
}

template <class real>
void pack_contacts(Buffers<real>& buffers, const StepParams<real>& params) {
  auto& counters = buffers.counters;
  const u32 contact_count = counters[COUNTER_CONTACTS];

  std::array<u32, MAX_COLORS + 1> sizes = {};
  for (u32 i = 0; i < contact_count; ++i) ++sizes[buffers.contact_colors[i]];
  u32 blocks = 0, colors = 0, large_colors = 0;
  for (u32 color = 0; color < MAX_COLORS; ++color) {
    buffers.color_starts[color] = blocks;
    const u32 size = (sizes[color] + PACK - 1) / PACK;
    blocks += size;
    if (size > 0) colors = color + 1;
    if (size >= LARGE_COLOR) large_colors = color + 1;
  }
  buffers.color_starts[MAX_COLORS] = blocks;
  blocks += sizes[MAX_COLORS];
  buffers.color_starts[MAX_COLORS + 1] = blocks;

  counters[COUNTER_COLORS] = colors;
  counters[COUNTER_LARGE_COLORS] = large_colors;
  counters[COUNTER_OVERFLOW] = sizes[MAX_COLORS];
  counters[COUNTER_BLOCKS_NEEDED] = blocks;
  counters[COUNTER_BLOCKS] = std::min(blocks, params.block_capacity);
  if (blocks > params.block_capacity) counters[COUNTER_STATUS] |= STATUS_BLOCKS_FULL;

  for (u32 block = 0; block < counters[COUNTER_BLOCKS]; ++block) {
    BlockBodies& bodies = buffers.block_bodies[block];
    std::fill_n(bodies.body_a, PACK, params.bodies);
    std::fill_n(bodies.body_b, PACK, params.bodies);
    std::fill_n(bodies.kind, PACK, u32{BLOCK_PADDING});
    std::fill_n(bodies.contact, PACK, NONE);
  }

  std::array<u32, MAX_COLORS + 1> placed = {};
  for (u32 i = 0; i < contact_count; ++i) {
    const u32 color = buffers.contact_colors[i];
    const u32 place = placed[color]++;
    const u32 slot = buffers.color_starts[color] * PACK + (color == MAX_COLORS ? place * PACK : place);
    buffers.contact_slots[i] = slot;
    if (slot / PACK >= params.block_capacity) continue;
    const Contact& contact = buffers.contacts[i];
    const bool central =
        is_central(buffers, contact.body_a, contact.shape_a) && is_central(buffers, contact.body_b, contact.shape_b);
    BlockBodies& bodies = buffers.block_bodies[slot / PACK];
    bodies.body_a[slot % PACK] = contact.body_a;
    bodies.body_b[slot % PACK] = contact.body_b;
    bodies.kind[slot % PACK] = central ? BLOCK_CENTRAL : BLOCK_GENERAL;
    bodies.contact[slot % PACK] = i;
  }
}

}  // namespace lockstep::reference
