#pragma OPENCL FP_CONTRACT OFF
// Tiles of contacts, and which of them share a movable body (cpu_reference/couple_contacts.hpp). Each body keeps the
// tiles of its world that it has contacts in, a bit each: a column's rows are those of its bodies together.
#include "common.h"
#include "rigid_body.h"
#include "types.h"

// Words of such a set.
#define COUPLE_WORDS (DENSE_CONTACTS / PACK / 32u)

static inline u32 couple_tiles(const StepParams* params) { return params->contact_capacity / PACK + params->worlds; }

kernel void couple_clear(const StepParams params, global ContactTile* contact_tiles, global u32* body_tiles) {
  FOR_EACH(i, params.bodies * COUPLE_WORDS) body_tiles[i] = 0u;
  FOR_EACH(tile, couple_tiles(&params)) contact_tiles[tile].first = contact_tiles[tile].count = 0u;
}

static inline void couple_note(u32 tile, u32 body, global const BodyInfo* body_infos, global u32* body_tiles) {
  if (body_infos[body].kind == BODY_DYNAMIC)
    atomic_or(&body_tiles[body * COUPLE_WORDS + tile / 32u], 1u << (tile % 32u));
}

kernel void couple_mark(global const Contact* contacts, global const BodyInfo* body_infos,
                        global ContactTile* contact_tiles, global u32* body_tiles, global u32* counters) {
  const u32 contact_count = counters[COUNTER_CONTACTS];
  FOR_EACH(i, contact_count) {
    const Contact contact = contacts[i];
    const u32 rank = contact.rank;
    if (rank >= DENSE_CONTACTS) {
      report_bad(counters, STATUS_TOO_DENSE, contact.body_a);
      continue;
    }
    couple_note(rank / PACK, contact.body_a, body_infos, body_tiles);
    couple_note(rank / PACK, contact.body_b, body_infos, body_tiles);
    if (rank % PACK != 0u) continue;
    u32 count = 1u;
    while (count < PACK && i + count < contact_count && contacts[i + count].rank == rank + count) ++count;
    global ContactTile* tile = contact_tiles + ((i - rank) / PACK + contact.world + rank / PACK);
    tile->first = i;
    tile->count = count;
  }
}

// The rows that feel what is done in a tile, as a set.
static inline void couple_rows(ContactTile tile, global const Contact* contacts, global const BodyInfo* body_infos,
                               global const u32* body_tiles, u32* rows) {
  for (u32 word = 0u; word < COUPLE_WORDS; ++word) rows[word] = 0u;
  for (u32 i = tile.first; i < tile.first + tile.count; ++i) {
    const u32 a = contacts[i].body_a, b = contacts[i].body_b;
    const u32 of_a = body_infos[a].kind == BODY_DYNAMIC ? 0xffffffffu : 0u;
    const u32 of_b = body_infos[b].kind == BODY_DYNAMIC ? 0xffffffffu : 0u;
    for (u32 word = 0u; word < COUPLE_WORDS; ++word)
      rows[word] |= (body_tiles[a * COUPLE_WORDS + word] & of_a) | (body_tiles[b * COUPLE_WORDS + word] & of_b);
  }
}

kernel void couple_count(const StepParams params, global const Contact* contacts, global const BodyInfo* body_infos,
                         global const ContactTile* contact_tiles, global const u32* body_tiles,
                         global u32* tile_starts) {
  FOR_EACH(column, couple_tiles(&params) + 1u) {
    u32 count = 0u;
    if (column < couple_tiles(&params)) {
      u32 rows[COUPLE_WORDS];
      couple_rows(contact_tiles[column], contacts, body_infos, body_tiles, rows);
      for (u32 word = 0u; word < COUPLE_WORDS; ++word) count += popcount(rows[word]);
    }
    tile_starts[column] = count;
  }
}

kernel void couple_fill(const StepParams params, const u32 coupled_tile_capacity, global const Contact* contacts,
                        global const BodyInfo* body_infos, global const ContactTile* contact_tiles,
                        global const u32* body_tiles, global const u32* tile_starts, global CoupledTiles* coupled_tiles,
                        global u32* counters) {
  FOR_EACH(column, couple_tiles(&params)) {
    const ContactTile tile = contact_tiles[column];
    if (tile.count == 0u) continue;
    u32 rows[COUPLE_WORDS];
    couple_rows(tile, contacts, body_infos, body_tiles, rows);
    const u32 first = column - contacts[tile.first].rank / PACK;  // of the world
    u32 slot = tile_starts[column];
    for (u32 row = 0u; row < 32u * COUPLE_WORDS; ++row) {
      if ((rows[row / 32u] >> (row % 32u) & 1u) == 0u) continue;
      if (slot < coupled_tile_capacity) {
        coupled_tiles[slot].row = first + row;
        coupled_tiles[slot].column = column;
      }
      ++slot;
    }
  }
  if (get_global_id(0) != 0) return;
  const u32 needed = tile_starts[couple_tiles(&params)];
  counters[COUNTER_COUPLED_TILES_NEEDED] = needed;
  if (needed > coupled_tile_capacity) atomic_or(&counters[COUNTER_STATUS], STATUS_COUPLED_TILES_FULL);
}
