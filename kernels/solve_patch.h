// Solves LANES pairs whose contacts share one friction patch. cpu_reference/solve_patch.hpp is the twin and states the
// method.
#ifndef LOCKSTEP_SOLVE_PATCH_H
#define LOCKSTEP_SOLVE_PATCH_H

#include "solve_contact.h"

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

static inline LaneDiscInverse lane_patch_friction_inverse(global const PatchBlock* block, u32 first) {
  LaneDiscInverse inverse;
  inverse.xx = LANE_LOAD(block->inverse_11 + first), inverse.xy = LANE_LOAD(block->inverse_12 + first);
  inverse.yy = LANE_LOAD(block->inverse_22 + first);
  return inverse;
}

// A row of normals; returns their impulses. `change` keeps the largest of the squared changes of velocities.
static inline lane solve_normals(const u32 purpose, u32 first, global const ContactBlock* block,
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
// holds, and the rotation counts at the radius of gyration of the two bodies about the normal.
static inline lane lane_patch_friction_change(global const PatchBlock* block, u32 first, lane d_1, lane d_2,
                                              lane d_twist, const LaneBody* a, const LaneBody* b) {
  const LaneDisc u = lane_disc_velocity(d_1, d_2, lane_patch_friction_inverse(block, first));
  const lane twist_change =
      d_twist * d_twist * (a->inverse_mass + b->inverse_mass) / LANE_LOAD(block->inverse_twist + first);
  return lane_larger(u.x * u.x + u.y * u.y, lane_larger(twist_change, (lane)0));
}
#endif

// Twist and friction, under the sums of the normal impulses and of their moments about the normal.
static inline void solve_patch_friction(u32 first, lane load, lane moment, global const PatchBlock* block,
                                        global PatchImpulse* impulses, LaneBody* a, LaneBody* b, lane* change) {
  const lane friction = LANE_LOAD(block->friction + first);
  const lane limit = friction * load, twist_limit = friction * moment;
  const LaneContact c = lane_patch(block, first);

  const lane old_twist = LANE_LOAD(impulses->twist + first);
  const lane wanted = old_twist - LANE_LOAD(block->inverse_twist + first) * lane_dot3(c.normal, lane_sub3(a->w, b->w));
  const lane twist = wanted > twist_limit ? twist_limit : (wanted < -twist_limit ? -twist_limit : wanted);
  LANE_STORE(twist, impulses->twist + first);
  lane_twist_by(LANE_EACH, lane_scale3(twist - old_twist, c.normal), a, b);

  const Lane3 u = lane_velocity_at(c.arm_a, c.arm_b, a, b);
  LaneDisc old, slip;
  old.x = LANE_LOAD(impulses->tangent_1 + first), old.y = LANE_LOAD(impulses->tangent_2 + first);
  slip.x = lane_dot3(c.tangent_1, u), slip.y = lane_dot3(c.tangent_2, u);
  const LaneDisc r = lane_solve_friction_disc(old, slip, lane_patch_friction_inverse(block, first), limit);
  LANE_STORE(r.x, impulses->tangent_1 + first);
  LANE_STORE(r.y, impulses->tangent_2 + first);
  lane_push_patch(c, r.x - old.x, r.y - old.y, a, b);
#if FEATURE_TOLERANCE
  *change =
      lane_larger(lane_patch_friction_change(block, first, r.x - old.x, r.y - old.y, twist - old_twist, a, b), *change);
#endif
}

// Solves the pairs in lanes first .. first + LANES - 1 of a block.
static inline void solve_patches(const u32 purpose, u32 first, global const BlockBodies* bodies, BlockRows rows,
                                 global const ContactBlock* contact_blocks, global const SoftnessBlock* softness_blocks,
                                 global ImpulseBlock* impulse_blocks, global const PatchBlock* patch,
                                 global PatchImpulse* patch_impulse, LaneBody* a, LaneBody* b, lane* change) {
  const lane_u32 count = LANE_LOAD_U32(bodies->count + first);
  for (u32 pass = 0u; pass < 2u; ++pass) {
    lane load = (lane)0, moment = (lane)0;
    for (u32 k = 0u; k < rows.count; ++k) {
      LaneBody next_a = *a, next_b = *b;
      const lane r = solve_normals(purpose, first, contact_blocks + rows.first + k, softness_blocks + rows.first + k,
                                   impulse_blocks + rows.first + k, &next_a, &next_b, change);
      const lane_mask there = LANE_MASK(count > (lane_u32)k);
      lane_select_body(there, next_a, a);
      lane_select_body(there, next_b, b);
      load = load + r;
      moment = moment + LANE_LOAD(patch->distance[k] + first) * r;
    }
    if (pass == 0u) solve_patch_friction(first, load, moment, patch, patch_impulse, a, b, change);
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
    lane_select_body(there, next_a, a);
    lane_select_body(there, next_b, b);
  }
#endif
  const LaneContact c = lane_patch(patch, first);
  lane_twist_by(LANE_EACH, lane_scale3(LANE_LOAD(patch_impulse->twist + first), c.normal), a, b);
  lane_push_patch(c, LANE_LOAD(patch_impulse->tangent_1 + first), LANE_LOAD(patch_impulse->tangent_2 + first), a, b);
}

#endif

#endif
