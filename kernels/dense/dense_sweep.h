// Sweeps over the contacts of a world by its dense Delassus matrix: a tile one contact after another, then all that
// feel it at once. cpu_reference/solve_dense.hpp is the twin.
#ifndef LOCKSTEP_DENSE_SWEEP_H
#define LOCKSTEP_DENSE_SWEEP_H

#include "dense/dense_matrix.h"
#include "pair_contacts.h"
#include "sweep_change.h"

// All that a sweep reads and writes.
typedef struct DenseProblem {
  global const Contact* contacts;
  global const ContactTile* contact_tiles;
  global const u32* tile_starts;
  global const CoupledTiles* coupled_tiles;
  global const DenseBlock* blocks;
  global DenseTile* tiles;
  global u32* counters;
} DenseProblem;

// Of the parameters of a kernel.
#define DENSE_PROBLEM \
  { contacts, contact_tiles, tile_starts, coupled_tiles, dense_blocks, dense_tiles, counters }

#if LANES == 1
#define DENSE_FIRST(x) (x)
#else
#define DENSE_FIRST(x) ((x).s0)
#endif

// Contact k of a tile, the same in all lanes.
static inline LaneCone dense_spread(global const real (*x)[PACK], u32 k) {
  return lane_make_cone((lane)x[0][k], (lane)x[1][k], (lane)x[2][k]);
}

// What has not changed is felt by none, as u is never -0: contacts that are open, most of all.
static inline bool dense_is_still(global const real (*d)[PACK], u32 k) {
  return d[0][k] == (real)0 && d[1][k] == (real)0 && d[2][k] == (real)0;
}

// u = u + W d of the rows in lanes first .. first + LANES - 1 of a tile.
static inline void dense_feel(u32 k, u32 first, LaneCone d, global const DenseBlock* block, LaneCone* u) {
  global const real(*w)[3][PACK] = block->w[k];
  u->normal = u->normal + (LANE_LOAD(w[0][0] + first) * d.normal + LANE_LOAD(w[0][1] + first) * d.tangent_1 +
                           LANE_LOAD(w[0][2] + first) * d.tangent_2);
  u->tangent_1 = u->tangent_1 + (LANE_LOAD(w[1][0] + first) * d.normal + LANE_LOAD(w[1][1] + first) * d.tangent_1 +
                                 LANE_LOAD(w[1][2] + first) * d.tangent_2);
  u->tangent_2 = u->tangent_2 + (LANE_LOAD(w[2][0] + first) * d.normal + LANE_LOAD(w[2][1] + first) * d.tangent_1 +
                                 LANE_LOAD(w[2][2] + first) * d.tangent_2);
}

static inline LaneCone dense_load(global const real (*x)[PACK], u32 first) {
  return lane_make_cone(LANE_LOAD(x[0] + first), LANE_LOAD(x[1] + first), LANE_LOAD(x[2] + first));
}
static inline void dense_store(LaneCone x, global real (*to)[PACK], u32 first) {
  LANE_STORE(x.normal, to[0] + first);
  LANE_STORE(x.tangent_1, to[1] + first);
  LANE_STORE(x.tangent_2, to[2] + first);
}

// Solves contact k for itself, and returns by what its impulse changes. All lanes do the same.
static inline LaneCone dense_solve_contact(u32 k, global const DenseBlock* own, global DenseTile* tile, lane* change) {
  const lane_mask all = (lane_mask)-1;
  global const real(*block)[3][PACK] = own->w[k];
  LaneDelassus w;
  w.nn = (lane)block[0][0][k], w.t11 = (lane)block[1][1][k], w.t22 = (lane)block[2][2][k];
  w.n1 = (lane)block[0][1][k], w.n2 = (lane)block[0][2][k], w.t12 = (lane)block[1][2][k];
  const LaneCone u = dense_spread(tile->u, k), old = dense_spread(tile->r, k);
  const LaneCone q = lane_make_cone(u.normal - (w.nn * old.normal + w.n1 * old.tangent_1 + w.n2 * old.tangent_2),
                                    u.tangent_1 - (w.n1 * old.normal + w.t11 * old.tangent_1 + w.t12 * old.tangent_2),
                                    u.tangent_2 - (w.n2 * old.normal + w.t12 * old.tangent_1 + w.t22 * old.tangent_2));
  const LaneCone r = lane_solve_general(all, q, w, (lane)tile->friction[k]);
  const LaneCone d = lane_make_cone(r.normal - old.normal, r.tangent_1 - old.tangent_1, r.tangent_2 - old.tangent_2);
  tile->r[0][k] = DENSE_FIRST(r.normal), tile->r[1][k] = DENSE_FIRST(r.tangent_1);
  tile->r[2][k] = DENSE_FIRST(r.tangent_2);
  tile->d[0][k] = DENSE_FIRST(d.normal), tile->d[1][k] = DENSE_FIRST(d.tangent_1);
  tile->d[2][k] = DENSE_FIRST(d.tangent_2);
#if FEATURE_TOLERANCE
  const LaneCone wd = lane_make_cone(w.nn * d.normal + w.n1 * d.tangent_1 + w.n2 * d.tangent_2,
                                     w.n1 * d.normal + w.t11 * d.tangent_1 + w.t12 * d.tangent_2,
                                     w.n2 * d.normal + w.t12 * d.tangent_1 + w.t22 * d.tangent_2);
  *change = lane_larger(wd.normal * wd.normal + wd.tangent_1 * wd.tangent_1 + wd.tangent_2 * wd.tangent_2, *change);
#endif
  return d;
}

// One work-item: the contacts of a tile one after another.
static inline void dense_solve_tile(u32 tile, const DenseProblem* p) {
  u32 pair = p->tile_starts[tile];
  while (p->coupled_tiles[pair].row != tile) ++pair;
  global const DenseBlock* own = p->blocks + pair;
  global DenseTile* at = p->tiles + tile;
  const u32 count = p->contact_tiles[tile].count;
  lane change = (lane)0;
  for (u32 k = 0u; k < count; ++k) {
    const LaneCone d = dense_solve_contact(k, own, at, &change);
    if (dense_is_still(at->d, k)) continue;
    for (u32 first = 0u; first < PACK; first += LANES) {
      LaneCone u = dense_load(at->u, first);
      dense_feel(k, first, d, own, &u);
      dense_store(u, at->u, first);
    }
  }
#if FEATURE_TOLERANCE
  note_change(change, p->counters);
#endif
}

// What the other tiles feel of it: an item has LANES rows of one of them, which take its contacts in their order.
static inline void dense_feel_tile(u32 tile, u32 item, const DenseProblem* p) {
  const u32 pair = p->tile_starts[tile] + item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
  const u32 row = p->coupled_tiles[pair].row, count = p->contact_tiles[tile].count;
  if (row == tile) return;
  global const real(*changes)[PACK] = p->tiles[tile].d;
  LaneCone u = dense_load(p->tiles[row].u, first);
  for (u32 k = 0u; k < count; ++k) {
    if (!dense_is_still(changes, k)) dense_feel(k, first, dense_spread(changes, k), p->blocks + pair, &u);
  }
  dense_store(u, p->tiles[row].u, first);
}

// A work-group has a world for itself, and every n-th behind it. At least one round in each loop, as in all with a
// barrier.
static inline void dense_sweep_worlds(u32 sweeps, u32 worlds, const DenseProblem* p) {
  const u32 contacts = p->counters[COUNTER_CONTACTS];
  u32 world = (u32)get_group_id(0);
  do {
    const bool is_there = world < worlds && !SWEEP_SKIPPED(p->counters);
    const u32 first = is_there ? first_contact_of_world(world, contacts, p->contacts) : 0u;
    const u32 count = is_there ? first_contact_of_world(world + 1u, contacts, p->contacts) - first : 0u;
    const u32 tiles = (count + PACK - 1u) / PACK, steps = sweeps * tiles;
    u32 step = 0u;
    do {
      const u32 tile = first / PACK + world + (step < steps ? step % tiles : 0u);
      if (step < steps && get_local_id(0) == 0) dense_solve_tile(tile, p);
      barrier(CLK_GLOBAL_MEM_FENCE);
      const u32 items = step < steps ? (p->tile_starts[tile + 1u] - p->tile_starts[tile]) * ITEMS_PER_BLOCK : 0u;
      for (u32 item = (u32)get_local_id(0); item < items; item += (u32)get_local_size(0))
        dense_feel_tile(tile, item, p);
      barrier(CLK_GLOBAL_MEM_FENCE);
    } while (++step < steps);
    world += (u32)get_num_groups(0);
  } while (world < worlds);
}

#endif
