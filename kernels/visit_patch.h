// The visit of LANES pairs whose contacts rub as one. cpu_reference/visit_patch.hpp is the twin and states the method.
#ifndef LOCKSTEP_VISIT_PATCH_H
#define LOCKSTEP_VISIT_PATCH_H

#include "visit_contact.h"

#if FEATURE_PATCHES

// All inertias are taken whole, those of central contacts too.
#define LANE_EACH ((lane_mask)(-1))

static inline LaneContact lane_patch(global const PatchBlock* block, u32 first) {
  return lane_frame(LANE_NORMAL(block, first), LANE_ARM_A(block, first), LANE_ARM_B(block, first));
}

static inline void lane_push_patch(LaneContact c, lane r_1, lane r_2, LaneBody* a, LaneBody* b) {
  lane_push_at(c.arm_a, c.arm_b, LANE_EACH, lane_add3(lane_scale3(r_1, c.tangent_1), lane_scale3(r_2, c.tangent_2)), a,
               b);
}

// A moment on a, its opposite on b.
static inline void lane_twist_by(Lane3 moment, LaneBody* a, LaneBody* b) {
  a->w = lane_add3(a->w, lane_turn_by(*a, moment));
  b->w = lane_sub3(b->w, lane_turn_by(*b, moment));
}

// A row of normals; returns their impulses. `change` keeps the largest of the squared changes of velocities.
static inline lane visit_normals(const u32 purpose, u32 first, global const ContactBlock* block,
                                 global const SoftnessBlock* softness_block, global ImpulseBlock* impulses, LaneBody* a,
                                 LaneBody* b, lane* change) {
  const Lane3 n = LANE_NORMAL(block, first), arm_a = LANE_ARM_A(block, first), arm_b = LANE_ARM_B(block, first);
  const LaneLaw law = lane_law(purpose, block, softness_block, first);
  const lane u_n = lane_dot3(n, lane_velocity_at(arm_a, arm_b, a, b)) + law.bias;
  const lane old = LANE_LOAD(impulses->normal + first);
  const lane next = old - (u_n + law.softness * old) / (law.w_nn + law.softness);
  const lane r = next > (lane)0 ? next : (lane)0;
  LANE_STORE(r, impulses->normal + first);
  lane_push_at(arm_a, arm_b, LANE_EACH, lane_scale3(r - old, n), a, b);
#if FEATURE_TOLERANCE
  const lane u_change = law.w_nn * (r - old);
  *change = lane_larger(u_change * u_change, *change);
#endif
  return r;
}

#if FEATURE_TOLERANCE
// The squares of what changes of friction and twist make of the relative velocity: W is the inverse of what the block
// holds, and the turn counts at the radius of gyration of the two bodies about the normal.
static inline lane lane_rubbing_change(global const PatchBlock* block, u32 first, lane d_1, lane d_2, lane d_twist,
                                       const LaneBody* a, const LaneBody* b) {
  const lane inverse_11 = LANE_LOAD(block->inverse_11 + first), inverse_12 = LANE_LOAD(block->inverse_12 + first);
  const lane inverse_22 = LANE_LOAD(block->inverse_22 + first);
  const lane determinant = inverse_11 * inverse_22 - inverse_12 * inverse_12;
  const lane u_1 = (inverse_22 * d_1 - inverse_12 * d_2) / determinant;
  const lane u_2 = (inverse_11 * d_2 - inverse_12 * d_1) / determinant;
  const lane turned = d_twist * d_twist * (a->inverse_mass + b->inverse_mass) / LANE_LOAD(block->inverse_twist + first);
  return lane_larger(u_1 * u_1 + u_2 * u_2, lane_larger(turned, (lane)0));
}
#endif

// Twist and friction, under the sums of the normal impulses and of their levers.
static inline void visit_rubbing(u32 first, lane load, lane moment, global const PatchBlock* block,
                                 global PatchImpulse* impulses, LaneBody* a, LaneBody* b, lane* change) {
  const lane friction = LANE_LOAD(block->friction + first);
  const lane limit = friction * load, reach = friction * moment;
  const LaneContact c = lane_patch(block, first);

  const lane old_twist = LANE_LOAD(impulses->twist + first);
  const lane wanted = old_twist - LANE_LOAD(block->inverse_twist + first) * lane_dot3(c.normal, lane_sub3(a->w, b->w));
  const lane twist = wanted > reach ? reach : (wanted < -reach ? -reach : wanted);
  LANE_STORE(twist, impulses->twist + first);
  lane_twist_by(lane_scale3(twist - old_twist, c.normal), a, b);

  const Lane3 u = lane_velocity_at(c.arm_a, c.arm_b, a, b);
  const lane u_1 = lane_dot3(c.tangent_1, u), u_2 = lane_dot3(c.tangent_2, u);
  const lane old_1 = LANE_LOAD(impulses->tangent_1 + first), old_2 = LANE_LOAD(impulses->tangent_2 + first);
  const lane inverse_11 = LANE_LOAD(block->inverse_11 + first), inverse_12 = LANE_LOAD(block->inverse_12 + first);
  const lane inverse_22 = LANE_LOAD(block->inverse_22 + first);
  const lane stick_1 = old_1 - (inverse_11 * u_1 + inverse_12 * u_2);
  const lane stick_2 = old_2 - (inverse_12 * u_1 + inverse_22 * u_2);
  const lane_mask slips = sqrt(stick_1 * stick_1 + stick_2 * stick_2) > limit;
  const lane rho = (lane)2 * (inverse_11 * inverse_22 - inverse_12 * inverse_12) / (inverse_11 + inverse_22);
  const lane slip_1 = old_1 - rho * u_1, slip_2 = old_2 - rho * u_2;
  const lane length = sqrt(slip_1 * slip_1 + slip_2 * slip_2);
  const lane scale = length > limit ? limit / length : (lane)1;
  const lane r_1 = slips ? scale * slip_1 : stick_1, r_2 = slips ? scale * slip_2 : stick_2;
  LANE_STORE(r_1, impulses->tangent_1 + first);
  LANE_STORE(r_2, impulses->tangent_2 + first);
  lane_push_patch(c, r_1 - old_1, r_2 - old_2, a, b);
#if FEATURE_TOLERANCE
  *change = lane_larger(lane_rubbing_change(block, first, r_1 - old_1, r_2 - old_2, twist - old_twist, a, b), *change);
#endif
}

// Visits the pairs in lanes first .. first + LANES - 1 of a block.
static inline void visit_patches(const u32 purpose, u32 first, global const BlockBodies* bodies, BlockRows rows,
                                 global const ContactBlock* contact_blocks, global const SoftnessBlock* softness_blocks,
                                 global ImpulseBlock* impulse_blocks, global const PatchBlock* patch,
                                 global PatchImpulse* patch_impulse, LaneBody* a, LaneBody* b, lane* change) {
  const lane_u32 count = LANE_LOAD_U32(bodies->count + first);
  for (u32 pass = 0u; pass < 2u; ++pass) {
    lane load = (lane)0, moment = (lane)0;
    for (u32 k = 0u; k < rows.count; ++k) {
      LaneBody next_a = *a, next_b = *b;
      const lane r = visit_normals(purpose, first, contact_blocks + rows.first + k, softness_blocks + rows.first + k,
                                   impulse_blocks + rows.first + k, &next_a, &next_b, change);
      const lane_mask there = LANE_MASK(count > (lane_u32)k);
      visit_keep(there, next_a, a);
      visit_keep(there, next_b, b);
      load = load + r;
      moment = moment + LANE_LOAD(patch->lever[k] + first) * r;
    }
    if (pass == 0u) visit_rubbing(first, load, moment, patch, patch_impulse, a, b, change);
  }
}

static inline void start_normals(u32 first, global const ContactBlock* block, global const ImpulseBlock* impulses,
                                 LaneBody* a, LaneBody* b) {
  const Lane3 impulse = lane_scale3(LANE_LOAD(impulses->normal + first), LANE_NORMAL(block, first));
  lane_push_at(LANE_ARM_A(block, first), LANE_ARM_B(block, first), LANE_EACH, impulse, a, b);
}

// Gives the bodies the impulses that the pairs start from.
static inline void start_patches(u32 first, global const BlockBodies* bodies, BlockRows rows,
                                 global const ContactBlock* contact_blocks, global const ImpulseBlock* impulse_blocks,
                                 global const PatchBlock* patch, global const PatchImpulse* patch_impulse, LaneBody* a,
                                 LaneBody* b) {
  start_normals(first, contact_blocks + rows.first, impulse_blocks + rows.first, a, b);
#if FEATURE_MANIFOLDS
  const lane_u32 count = LANE_LOAD_U32(bodies->count + first);
  for (u32 k = 1u; k < rows.count; ++k) {
    LaneBody next_a = *a, next_b = *b;
    start_normals(first, contact_blocks + rows.first + k, impulse_blocks + rows.first + k, &next_a, &next_b);
    const lane_mask there = LANE_MASK(count > (lane_u32)k);
    visit_keep(there, next_a, a);
    visit_keep(there, next_b, b);
  }
#endif
  const LaneContact c = lane_patch(patch, first);
  lane_twist_by(lane_scale3(LANE_LOAD(patch_impulse->twist + first), c.normal), a, b);
  lane_push_patch(c, LANE_LOAD(patch_impulse->tangent_1 + first), LANE_LOAD(patch_impulse->tangent_2 + first), a, b);
}

#endif

#endif
