// The order of the solves: what the solver's sweeps and the warm start share. A phase is a colour, or one overflow
// block: the phases of a step follow one another, what is in a phase runs at once, LANES pairs an item.
#ifndef LOCKSTEP_SWEEP_CONTACTS_H
#define LOCKSTEP_SWEEP_CONTACTS_H

#include "solve_angular_friction.h"
#include "solve_contact.h"
#include "solve_normals.h"
#include "solve_patch.h"

// All that a solve reads and writes; those that the scene has no need of are null.
typedef struct ContactStream {
  global const BlockBodies* bodies;
  global const BlockRows* rows;
  global const ContactBlock* contacts;
  global const SoftnessBlock* softness;
  global const SlideBlock* slides;
  global const AngularFrictionBlock* angular_friction;
  global const EllipseBlock* ellipses;
  global NormalCoupling* couplings;
  global const PatchBlock* patches;
  global ImpulseBlock* impulses;
  global AngularFrictionImpulse* angular_friction_impulses;
  global PatchImpulse* patch_impulses;
  global Motion* motions;
  global u32* counters;
} ContactStream;

// Of the parameters of a kernel, which are called as the buffers are.
#define CONTACT_STREAM                                                                                                \
  {                                                                                                                   \
    block_bodies, block_rows, contact_blocks, softness_blocks, slide_blocks, angular_friction_blocks, ellipse_blocks, \
        normal_couplings, patch_blocks, impulse_blocks, angular_friction_impulses, patch_impulses, motions, counters  \
  }

// One solve of row `row` of a block.
static inline void solve_row(const u32 purpose, u32 first, u32 row, lane_mask general, const ContactStream* s,
                             LaneBody* a, LaneBody* b, lane* change) {
#if FEATURE_ANGULAR_FRICTION
  solve_angular_friction(first, general, lane_law(purpose, s->contacts + row, s->softness + row, first),
                         s->contacts + row, s->slides + row, s->angular_friction + row, s->ellipses + row,
                         s->impulses + row, s->angular_friction_impulses + row, a, b, change);
#else
  solve_contact_row(purpose, first, general, s->contacts + row, s->softness + row, s->slides + row, s->impulses + row,
                    a, b, change);
#endif
}

#if FEATURE_COUPLED_NORMALS
// Those that are hit, from now on: of hard contacts all, of springs those with a point that closes fast.
static inline lane_mask hit_pairs(u32 first, u32 block, lane_mask several, const ContactStream* s, const LaneBody* a,
                                  const LaneBody* b) {
#if FEATURE_SOFT_CONTACTS
  const BlockRows rows = s->rows[block];
  if (rows.count < 2u) return (lane)0 > (lane)0;
  const lane_mask pairs =
      several & lane_hit_pairs(first, rows.count, s->couplings + block, s->contacts + rows.first, a, b);
  global real* const hit_speed = s->couplings[block].hit_speed + first;
  if (LANE_ANY(pairs)) LANE_STORE(pairs ? -fabs(LANE_LOAD(hit_speed)) : LANE_LOAD(hit_speed), hit_speed);
  return pairs;
#else
  return several;
#endif
}

// Those of which springs push a point out faster than its hit_speed.
static inline lane_mask pushed_out_pairs(u32 first, u32 block, lane_mask several, const ContactStream* s) {
  lane_mask pushed_out = (lane)0 > (lane)0;
#if FEATURE_SOFT_CONTACTS
  const BlockRows rows = s->rows[block];
  const lane hit_speed = fabs(LANE_LOAD(s->couplings[block].hit_speed + first));
  for (u32 row = rows.first; row < rows.first + rows.count; ++row) {
    pushed_out = pushed_out | ((LANE_LOAD(s->softness[row].softness + first) > (lane)0) &
                               (LANE_LOAD(s->contacts[row].bias + first) < -hit_speed));
  }
#endif
  return several & pushed_out;
}

// The normals of `pairs`, where there are any.
static inline void solve_pair_normals(const u32 purpose, u32 first, u32 block, lane_mask pairs, lane_mask general,
                                      const ContactStream* s, LaneBody* a, LaneBody* b) {
  if (!LANE_ANY(pairs)) return;
  const BlockRows rows = s->rows[block];
  solve_coupled_normals(purpose, first, rows.count, pairs, general, s->couplings + block, s->contacts + rows.first,
                        s->softness + rows.first, s->impulses + rows.first, a, b);
}
#endif

// Solves the pairs in lanes first .. first + LANES - 1 of a block: the contacts of a pair one after another, and their
// normals together before and behind them (cpu_reference/sweep_contacts.hpp says when).
static inline void solve_pairs(const u32 purpose, u32 first, u32 block, const ContactStream* s, LaneBody* a,
                               LaneBody* b, lane* change) {
  global const BlockBodies* bodies = s->bodies + block;
  const BlockRows rows = s->rows[block];
  const lane_mask general = lane_general(bodies, first);
#if FEATURE_MANIFOLDS
  const lane_u32 count = LANE_LOAD_U32(bodies->count + first);
#endif
#if FEATURE_COUPLED_NORMALS
  const lane_mask several = LANE_MASK(count > (lane_u32)1);
  const lane_mask pushed_out =
      purpose == PURPOSE_RELAX ? pushed_out_pairs(first, block, several, s) : several & !several;
  solve_pair_normals(purpose, first, block, pushed_out | hit_pairs(first, block, several & !pushed_out, s, a, b),
                     general, s, a, b);
#endif
  solve_row(purpose, first, rows.first, general, s, a, b, change);
#if FEATURE_MANIFOLDS
  for (u32 k = 1u; k < rows.count; ++k) {
    LaneBody next_a = *a, next_b = *b;
    solve_row(purpose, first, rows.first + k, general, s, &next_a, &next_b, change);
    const lane_mask there = LANE_MASK(count > (lane_u32)k);
    lane_select_body(there, next_a, a);
    lane_select_body(there, next_b, b);
  }
#endif
#if FEATURE_COUPLED_NORMALS
  solve_pair_normals(purpose, first, block, hit_pairs(first, block, several, s, a, b), general, s, a, b);
#endif
}

// The same, or their patches.
static inline void solve_pair_lanes(const u32 purpose, u32 block, u32 first, const ContactStream* s, LaneBody* a,
                                    LaneBody* b) {
  lane change = (lane)0;
#if FEATURE_PATCHES
  solve_patches(purpose, first, s->bodies + block, s->rows[block], s->contacts, s->softness, s->impulses,
                s->patches + block, s->patch_impulses + block, a, b, &change);
#else
  solve_pairs(purpose, first, block, s, a, b, &change);
#endif
#if FEATURE_TOLERANCE
  if (purpose == PURPOSE_SOLVE) note_change(change, s->counters);
#endif
}

// The item-th of a phase that begins with block `begin`.
static inline void solve_phase_item(const u32 purpose, u32 begin, u32 item, const ContactStream* s) {
  const u32 block = begin + item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
  global const BlockBodies* bodies = s->bodies + block;
  LaneBody a = lane_load_bodies(s->motions, bodies->body_a + first);
  LaneBody b = lane_load_bodies(s->motions, bodies->body_b + first);
  solve_pair_lanes(purpose, block, first, s, &a, &b);
  lane_store_bodies(a, s->motions, bodies->body_a + first);
  lane_store_bodies(b, s->motions, bodies->body_b + first);
}

static inline u32 contact_phases(global const u32* counters) {
  return SWEEP_SKIPPED(counters) ? 0u : counters[COUNTER_COLORS] + counters[COUNTER_OVERFLOW];
}
static inline u32 phase_begin(u32 phase, global const u32* color_starts, global const u32* counters) {
  const u32 colors = counters[COUNTER_COLORS];
  return phase < colors ? color_starts[phase] : color_starts[MAX_COLORS] + (phase - colors);
}
static inline u32 phase_end(u32 phase, global const u32* color_starts, global const u32* counters) {
  const u32 colors = counters[COUNTER_COLORS];
  return phase < colors ? color_starts[phase + 1u] : color_starts[MAX_COLORS] + (phase - colors) + 1u;
}

// One colour.
static inline void sweep_color(const u32 purpose, u32 color, global const u32* color_starts, const ContactStream* s) {
  const u32 begin = color_starts[color], items = (color_starts[color + 1u] - begin) * ITEMS_PER_BLOCK;
  FOR_EACH(item, items) solve_phase_item(purpose, begin, item, s);
}

// One work-group: the phases from `first_phase` on. At least one round, as in all loops with a
// barrier: what follows a barrier that may be skipped is compiled twice (docs/lab/performance.md).
static inline void sweep_tail(const u32 purpose, u32 first_phase, global const u32* color_starts,
                              const ContactStream* s, global const u32* counters) {
  const u32 phases = contact_phases(counters);
  u32 phase = min(first_phase, counters[COUNTER_COLORS]);
  do {
    // scenes of joints alone have no colours, nor where they start
    const bool is_there = phase < phases;
    const u32 begin = is_there ? phase_begin(phase, color_starts, counters) : 0u;
    const u32 items = is_there ? (phase_end(phase, color_starts, counters) - begin) * ITEMS_PER_BLOCK : 0u;
    FOR_EACH_OF_TEAM(item, 0u, items)
    solve_phase_item(purpose, begin, item, s);
    TEAM_BARRIER(counters);
  } while (++phase < phases);
}

#endif
