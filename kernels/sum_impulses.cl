#pragma OPENCL FP_CONTRACT OFF
// Adds what contacts and joints gave in a sub-step to what they gave before it in the step, LANES at a time
// (cpu_reference/sum_impulses.hpp).
#include "common.h"
#include "joints/solve_joint.h"
#include "lanes.h"
#include "solve_contact.h"
#include "spread_patch.h"
#include "types.h"

// The first sub-step begins anew.
static inline void sum_add(u32 substep, lane x, global real* sum) {
  LANE_STORE(substep > 0u ? LANE_LOAD(sum) + x : x, sum);
}

kernel void sum_contact_impulses(global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                                 global const ContactBlock* contact_blocks, global const ImpulseBlock* impulse_blocks,
                                 global const PatchBlock* patch_blocks, global const PatchImpulse* patch_impulses,
                                 global ImpulseSumBlock* impulse_sums, global const u32* counters,
                                 const StepParams params) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(item, counters[COUNTER_BLOCKS] * ITEMS_PER_BLOCK) {
    const u32 block = item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
    const BlockRows rows = block_rows[block];
    const lane_u32 count = LANE_LOAD_U32(block_bodies[block].count + first);
#if FEATURE_PATCHES
    const LaneSpread spread = spread_of(first, rows.count, count, contact_blocks + rows.first,
                                        impulse_blocks + rows.first, patch_blocks + block, patch_impulses + block);
#endif
    for (u32 k = 0u; k < rows.count; ++k) {
      const u32 row = rows.first + k;
#if FEATURE_PATCHES
      const LaneCone r = spread_to(&spread, first, contact_blocks + row, LANE_LOAD(impulse_blocks[row].normal + first));
#else
      const LaneCone r = lane_impulse(impulse_blocks + row, first);
#endif
      Lane3 impulse = lane_impulse_world(lane_contact(contact_blocks + row, first), r);
#if FEATURE_PATCHES
      impulse = lane_add3(impulse, spread.rest);
#endif
      const lane_mask there = LANE_MASK(count > (lane_u32)k);
      sum_add(params.substep, there ? impulse.x : (lane)0, impulse_sums[row].x + first);
      sum_add(params.substep, there ? impulse.y : (lane)0, impulse_sums[row].y + first);
      sum_add(params.substep, there ? impulse.z : (lane)0, impulse_sums[row].z + first);
    }
  }
}

#if FEATURE_JOINTS

#if FEATURE_NON_HOLONOMIC
// Of what rolls; 0 of other joints.
static inline lane sum_rolling_radius(u32 first, global const JointLanes* lanes, global const real* rolling_radii) {
  real radii[LANES];
  for (u32 k = 0u; k < LANES; ++k) {
    const u32 joint = lanes->joint[first + k];
    radii[k] = joint == NONE ? (real)0 : rolling_radii[joint];
  }
  return LANE_LOAD(radii);
}
#endif

static inline void sum_add3(u32 substep, Lane3 x, u32 first, global real (*sum)[PACK]) {
  sum_add(substep, x.x, sum[0] + first);
  sum_add(substep, x.y, sum[1] + first);
  sum_add(substep, x.z, sum[2] + first);
}

kernel void sum_joint_impulses(global const JointLanes* joint_lanes, global const JointBlock* joint_blocks,
                               global const JointImpulseBlock* joint_impulses, global const real* rolling_radii,
                               global JointSumBlock* joint_sums, global const u32* counters, const StepParams params) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(item, params.joint_blocks * ITEMS_PER_BLOCK) {
    const u32 block = item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
    global const JointLanes* lanes = joint_lanes + block;
    global JointSumBlock* sums = joint_sums + block;
    lane r[JOINT_ROWS];
    for (u32 i = 0u; i < JOINT_ROWS; ++i) r[i] = LANE_LOAD(joint_impulses[block].locked[i] + first);
    LaneEffort effort = lane_joint_effort(joint_blocks + block, lane_is_angular(lanes, first), first, r, (lane)0);
#if FEATURE_NON_HOLONOMIC
    const Lane3 down = lane_scale3(-sum_rolling_radius(first, lanes, rolling_radii),
                                   lane_joint_vector(joint_blocks[block].axes + 6, first));
    effort.moment = lane_add3(effort.moment, lane_cross3(down, effort.impulse));
#endif
    sum_add3(params.substep, effort.impulse, first, sums->impulse);
    sum_add3(params.substep, effort.moment, first, sums->moment);
    const lane r_free = lane_whole_free_impulse(
        joint_blocks + block, first, LANE_LOAD(joint_impulses[block].free + first), joint_impulses[block].impedance);
    sum_add(params.substep, r_free, sums->free + first);
  }
}

#endif
