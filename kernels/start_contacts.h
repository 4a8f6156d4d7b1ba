// Gives bodies impulses of their contacts, pair by pair in the order of the solves: those that the warm start begins
// from, or those by which a solver changed them (cpu_reference/sweep_contacts.hpp: start_pair).
#ifndef LOCKSTEP_START_CONTACTS_H
#define LOCKSTEP_START_CONTACTS_H

#include "sweep_contacts.h"

static inline void start_row(u32 first, u32 row, lane_mask general, global const ContactBlock* contact_blocks,
                             global const ImpulseBlock* impulse_blocks,
                             global const AngularFrictionBlock* angular_friction_blocks,
                             global const AngularFrictionImpulse* angular_friction_impulses, LaneBody* a, LaneBody* b) {
  const LaneContact c = lane_contact(contact_blocks + row, first);
  lane_push(c, general, lane_impulse(impulse_blocks + row, first), a, b);
#if FEATURE_ANGULAR_FRICTION
  lane_twist_by(general,
                lane_angular_friction_moment(c, angular_friction_blocks + row, angular_friction_impulses + row, first),
                a, b);
#endif
}

static inline void start_pairs(u32 first, global const BlockBodies* bodies, BlockRows rows,
                               global const ContactBlock* contact_blocks, global const ImpulseBlock* impulse_blocks,
                               global const AngularFrictionBlock* angular_friction_blocks,
                               global const AngularFrictionImpulse* angular_friction_impulses, LaneBody* a,
                               LaneBody* b) {
  const lane_mask general = lane_general(bodies, first);
  start_row(first, rows.first, general, contact_blocks, impulse_blocks, angular_friction_blocks,
            angular_friction_impulses, a, b);
#if FEATURE_MANIFOLDS
  const lane_u32 count = LANE_LOAD_U32(bodies->count + first);
  for (u32 k = 1u; k < rows.count; ++k) {
    LaneBody next_a = *a, next_b = *b;
    start_row(first, rows.first + k, general, contact_blocks, impulse_blocks, angular_friction_blocks,
              angular_friction_impulses, &next_a, &next_b);
    const lane_mask there = LANE_MASK(count > (lane_u32)k);
    lane_select_body(there, next_a, a);
    lane_select_body(there, next_b, b);
  }
#endif
}

static inline void start_lanes(u32 block, u32 first, global const BlockBodies* block_bodies,
                               global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                               global const ImpulseBlock* impulse_blocks,
                               global const AngularFrictionBlock* angular_friction_blocks,
                               global const AngularFrictionImpulse* angular_friction_impulses,
                               global const PatchBlock* patch_blocks, global const PatchImpulse* patch_impulses,
                               LaneBody* a, LaneBody* b) {
#if FEATURE_PATCHES
  start_patches(first, block_bodies + block, block_rows[block], contact_blocks, impulse_blocks, patch_blocks + block,
                patch_impulses + block, a, b);
#else
  start_pairs(first, block_bodies + block, block_rows[block], contact_blocks, impulse_blocks, angular_friction_blocks,
              angular_friction_impulses, a, b);
#endif
}

// All that an item reads and writes; those that the scene has no need of are null.
typedef struct StartStream {
  global const BlockBodies* bodies;
  global const BlockRows* rows;
  global const ContactBlock* contacts;
  global const ImpulseBlock* impulses;
  global const AngularFrictionBlock* angular_friction;
  global const AngularFrictionImpulse* angular_friction_impulses;
  global const PatchBlock* patches;
  global const PatchImpulse* patch_impulses;
  global Motion* motions;
} StartStream;

// Of the parameters of a kernel, which are called as the buffers are.
#define START_STREAM                                                                                              \
  {                                                                                                               \
    block_bodies, block_rows, contact_blocks, impulse_blocks, angular_friction_blocks, angular_friction_impulses, \
        patch_blocks, patch_impulses, motions                                                                     \
  }

static inline void start_item(u32 begin, u32 item, const StartStream* s) {
  const u32 block = begin + item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
  global const BlockBodies* bodies = s->bodies + block;
  LaneBody a = lane_load_bodies(s->motions, bodies->body_a + first);
  LaneBody b = lane_load_bodies(s->motions, bodies->body_b + first);
  start_lanes(block, first, s->bodies, s->rows, s->contacts, s->impulses, s->angular_friction,
              s->angular_friction_impulses, s->patches, s->patch_impulses, &a, &b);
  lane_store_bodies(a, s->motions, bodies->body_a + first);
  lane_store_bodies(b, s->motions, bodies->body_b + first);
}

#endif
