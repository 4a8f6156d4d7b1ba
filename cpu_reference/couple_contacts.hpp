// Cuts the contacts of each world into tiles, PACK at a time in the order of their list, and finds which tiles share a
// movable body: those blocks of the Delassus matrix are stored that are not zero for certain. Who is in which tile is
// no part of what is solved (cpu_reference/solve_dense.hpp), but how it is laid out.
#pragma once

#include <algorithm>
#include <vector>

#include "cpu_reference/math.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// The tile of contact `i`. The tiles of a world begin behind those that the contacts of the worlds before it can need.
inline u32 tile_of(const Contact& contact, u32 i) {
  return (i - contact.rank) / PACK + contact.world + contact.rank / PACK;
}

/// Calls function(body) for each body of a contact that can move.
template <class real, class Function>
void for_each_movable(const Buffers<real>& buffers, const Contact& contact, Function&& function) {
  for (const u32 body : {contact.body_a, contact.body_b})
    if (buffers.body_infos[body].kind == BODY_DYNAMIC) function(body);
}

template <class real>
void couple_contacts(Buffers<real>& buffers, const StepParams<real>& params) {
  auto& counters = buffers.counters;
  auto& tiles = buffers.contact_tiles;
  std::fill(tiles.begin(), tiles.end(), ContactTile{0, 0});
  std::vector<std::vector<u32>> tiles_of(params.bodies);  // in order, some more than once
  for (u32 i = 0; i < counters[COUNTER_CONTACTS]; ++i) {
    const Contact& contact = buffers.contacts[i];
    if (contact.rank >= DENSE_CONTACTS) {
      counters[COUNTER_STATUS] |= STATUS_TOO_DENSE;
      counters[COUNTER_BAD_BODY] = std::max(counters[COUNTER_BAD_BODY], NONE - contact.body_a);
      continue;
    }
    const u32 tile = tile_of(contact, i);
    if (contact.rank % PACK == 0) tiles[tile].first = i;
    ++tiles[tile].count;
    for_each_movable(buffers, contact, [&](u32 body) { tiles_of[body].push_back(tile); });
  }

  u32 pairs = 0;
  for (u32 column = 0; column < tiles.size(); ++column) {
    buffers.tile_starts[column] = pairs;
    std::vector<u32> rows;
    for (u32 i = tiles[column].first; i < tiles[column].first + tiles[column].count; ++i)
      for_each_movable(buffers, buffers.contacts[i],
                       [&](u32 body) { rows.insert(rows.end(), tiles_of[body].begin(), tiles_of[body].end()); });
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    for (const u32 row : rows) {
      if (pairs < buffers.coupled_tiles.size()) buffers.coupled_tiles[pairs] = {row, column};
      ++pairs;
    }
  }
  buffers.tile_starts.back() = pairs;
  counters[COUNTER_COUPLED_TILES_NEEDED] = pairs;
  if (pairs > buffers.coupled_tiles.size()) counters[COUNTER_STATUS] |= STATUS_COUPLED_TILES_FULL;
}

}  // namespace lockstep::reference
