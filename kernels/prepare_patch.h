// What the contacts of LANES pairs share in a sub-step where they share one friction patch.
// cpu_reference/prepare_patch.hpp is the twin and states the law.
#ifndef LOCKSTEP_PREPARE_PATCH_H
#define LOCKSTEP_PREPARE_PATCH_H

#include "lane_math.h"
#include "solve_patch.h"

#if FEATURE_PATCHES

// The centre of pressure: the mean of the ends of the arms, weighed by the normal impulses; where none presses yet, the
// plain mean.
static inline void patch_centre(u32 first, u32 rows, lane_u32 count, global const ContactBlock* contacts,
                                global const ImpulseBlock* impulses, Lane3* centre_a, Lane3* centre_b) {
  lane load = (lane)0, points = (lane)0;
  for (u32 k = 0u; k < rows; ++k) {
    load = load + LANE_LOAD(impulses[k].normal + first);
    points = points + (LANE_MASK(count > (lane_u32)k) ? (lane)1 : (lane)0);
  }
  for (u32 k = 0u; k < rows; ++k) {
    const lane share = load > (lane)0 ? LANE_LOAD(impulses[k].normal + first) / load : (lane)1 / points;
    const Lane3 a = lane_scale3(share, LANE_ARM_A(contacts + k, first));
    const Lane3 b = lane_scale3(share, LANE_ARM_B(contacts + k, first));
    const lane_mask there = LANE_MASK(count > (lane_u32)k);
    *centre_a = k == 0u ? a : lane_select3(there, lane_add3(*centre_a, a), *centre_a);
    *centre_b = k == 0u ? b : lane_select3(there, lane_add3(*centre_b, b), *centre_b);
  }
}

// The impulses to start from: those of the contacts at the beginning of a step, then the last ones turned.
static inline void patch_start(u32 substep, u32 first, u32 rows, lane_u32 count, Lane3 n, Lane3 centre,
                               global const ContactBlock* contacts, global const ImpulseBlock* impulses,
                               global const PatchBlock* block, global const PatchImpulse* patch_impulse, Lane3* tangent,
                               lane* twist) {
  if (substep > 0u) {
    const LaneContact old = lane_patch(block, first);
    *tangent = lane_add3(lane_scale3(LANE_LOAD(patch_impulse->tangent_1 + first), old.tangent_1),
                         lane_scale3(LANE_LOAD(patch_impulse->tangent_2 + first), old.tangent_2));
    const Lane3 moved = lane_sub3(old.arm_a, centre);
    *twist = LANE_LOAD(patch_impulse->twist + first) + lane_dot3(n, lane_cross3(moved, *tangent));
    return;
  }
  for (u32 k = 0u; k < rows; ++k) {
    const LaneContact c = lane_contact(contacts + k, first);
    const Lane3 t = lane_add3(lane_scale3(LANE_LOAD(impulses[k].tangent_1 + first), c.tangent_1),
                              lane_scale3(LANE_LOAD(impulses[k].tangent_2 + first), c.tangent_2));
    const lane moment = lane_dot3(n, lane_cross3(lane_sub3(c.arm_a, centre), t));
    const lane_mask there = LANE_MASK(count > (lane_u32)k);
    *tangent = k == 0u ? t : lane_select3(there, lane_add3(*tangent, t), *tangent);
    *twist = k == 0u ? moment : (there ? *twist + moment : *twist);
  }
}

// The rows of the pairs are prepared; `block` and `patch_impulse` still hold the last sub-step.
static inline void prepare_patches(u32 substep, u32 first, u32 rows, lane_u32 count, const LaneBody* a,
                                   const LaneBody* b, global const ContactBlock* contacts,
                                   global const ImpulseBlock* impulses, global PatchBlock* block,
                                   global PatchImpulse* patch_impulse) {
  const lane_mask there = LANE_MASK(count > (lane_u32)0);
  const Lane3 n = LANE_NORMAL(contacts, first);
  Lane3 t1, t2, centre_a, centre_b, tangent;
  lane twist;
  lane_tangents(n, &t1, &t2);
  patch_centre(first, rows, count, contacts, impulses, &centre_a, &centre_b);
  patch_start(substep, first, rows, count, n, centre_a, contacts, impulses, block, patch_impulse, &tangent, &twist);

  const Lane3 a_1 = lane_cross3(centre_a, t1), a_2 = lane_cross3(centre_a, t2);
  const Lane3 b_1 = lane_cross3(centre_b, t1), b_2 = lane_cross3(centre_b, t2);
  const Lane3 response_a = lane_apply_inverse_inertia(*a, a_2), response_b = lane_apply_inverse_inertia(*b, b_2);
  const lane inverse_mass = a->inverse_mass + b->inverse_mass;
  const lane w_11 = inverse_mass + (lane_dot3(a_1, lane_apply_inverse_inertia(*a, a_1)) +
                                    lane_dot3(b_1, lane_apply_inverse_inertia(*b, b_1)));
  const lane w_22 = inverse_mass + (lane_dot3(a_2, response_a) + lane_dot3(b_2, response_b));
  const lane w_12 = lane_dot3(a_1, response_a) + lane_dot3(b_1, response_b);
  const lane w_twist =
      lane_dot3(n, lane_apply_inverse_inertia(*a, n)) + lane_dot3(n, lane_apply_inverse_inertia(*b, n));
  const lane inverse = (lane)1 / (w_11 * w_22 - w_12 * w_12);

  lane_store_where(there, lane_dot3(tangent, t1), patch_impulse->tangent_1 + first);
  lane_store_where(there, lane_dot3(tangent, t2), patch_impulse->tangent_2 + first);
  lane_store_where(there, twist, patch_impulse->twist + first);
  lane_store_where(there, n.x, block->normal_x + first);
  lane_store_where(there, n.y, block->normal_y + first);
  lane_store_where(there, n.z, block->normal_z + first);
  lane_store_where(there, centre_a.x, block->arm_a_x + first);
  lane_store_where(there, centre_a.y, block->arm_a_y + first);
  lane_store_where(there, centre_a.z, block->arm_a_z + first);
  lane_store_where(there, centre_b.x, block->arm_b_x + first);
  lane_store_where(there, centre_b.y, block->arm_b_y + first);
  lane_store_where(there, centre_b.z, block->arm_b_z + first);
  lane_store_where(there, LANE_LOAD(contacts->friction + first), block->friction + first);
  for (u32 k = 0u; k < MANIFOLD_POINTS; ++k) {
    lane distance = (lane)0;
    if (k < rows) distance = lane_length3(lane_sub3(LANE_ARM_A(contacts + k, first), centre_a));
    lane_store_where(LANE_MASK(count > (lane_u32)k), distance, block->distance[k] + first);
  }
  lane_store_where(there, w_22 * inverse, block->inverse_11 + first);
  lane_store_where(there, -w_12 * inverse, block->inverse_12 + first);
  lane_store_where(there, w_11 * inverse, block->inverse_22 + first);
  lane_store_where(there & (w_twist > (lane)0), (lane)1 / w_twist, block->inverse_twist + first);
}

#endif

#endif
