// Adds what contacts and joints gave in a sub-step to what they gave before it in the step: what users are told as the
// impulses of a step. Normals, tangents and axes differ from one sub-step to the next, so that sums are vectors of the
// world. The sums feed nothing that is simulated.
//   contacts  r_n n + r_1 t_1 + r_2 t_2 on a; of pairs that share one friction patch, as it is spread over them,
//             and evenly what that leaves: normals are solved behind friction, about another centre of pressure
//   joints    sum r_i x_i on b and the moment of the locked rows about its anchor; the free row's impulse by itself
// A wheel is pushed where it touches, a radius below its anchor.
#pragma once

#include "cpu_reference/joints/solve_joint.hpp"
#include "cpu_reference/spread_patch.hpp"

namespace lockstep::reference {

/// The first sub-step begins anew.
template <class real>
void add_to_sum(u32 substep, real x, real& sum) {
  sum = substep > 0 ? sum + x : x;
}

template <class real>
void sum_contacts(Buffers<real>& b, u32 substep, u32 block, u32 lane) {
  const BlockRows& rows = b.block_rows[block];
  const u32 count = b.block_bodies[block].count[lane];
  PatchSpread<real> spread = {};
  if (!b.patch_blocks.empty() && count > 0)
    spread = spread_of(b.contact_blocks, b.impulse_blocks, rows.first, count, lane, b.patch_blocks[block],
                       b.patch_impulses[block]);
  for (u32 k = 0; k < rows.count; ++k) {
    const u32 row = rows.first + k;
    Vec3<real> impulse = {0, 0, 0};
    if (k < count) {
      const ContactBlock<real>& contact = b.contact_blocks[row];
      const ConeVector<real> own = impulse_of(b.impulse_blocks[row], lane);
      const ContactFrame<real> c = contact_frame<real>(contact, lane);
      impulse = b.patch_blocks.empty()
                    ? impulse_world(c, own)
                    : add3(impulse_world(c, spread_to(spread, contact, lane, own.normal)), spread.rest);
    }
    ImpulseSumBlock<real>& sum = b.impulse_sums[row];
    add_to_sum(substep, impulse.x, sum.x[lane]);
    add_to_sum(substep, impulse.y, sum.y[lane]);
    add_to_sum(substep, impulse.z, sum.z[lane]);
  }
}

template <class real>
void sum_joint(Buffers<real>& b, u32 substep, u32 block, u32 lane) {
  const JointLanes& lanes = b.joint_lanes[block];
  const JointImpulseBlock<real>& impulses = b.joint_impulses[block];
  real r[JOINT_ROWS];
  for (u32 i = 0; i < JOINT_ROWS; ++i) r[i] = impulses.locked[i][lane];
  JointEffort<real> effort = joint_effort(b.joint_blocks[block], lanes.free[lane], lane, r, real(0));
  if (!b.rolling_radii.empty()) {
    const real radius = lanes.joint[lane] == NONE ? real(0) : b.rolling_radii[lanes.joint[lane]];
    const Vec3<real> down = scale3(-radius, joint_vector(b.joint_blocks[block].axes + 6, lane));
    effort.moment = add3(effort.moment, cross3(down, effort.impulse));
  }
  JointSumBlock<real>& sum = b.joint_sums[block];
  const real impulse[3] = {effort.impulse.x, effort.impulse.y, effort.impulse.z};
  const real moment[3] = {effort.moment.x, effort.moment.y, effort.moment.z};
  for (u32 k = 0; k < 3; ++k) {
    add_to_sum(substep, impulse[k], sum.impulse[k][lane]);
    add_to_sum(substep, moment[k], sum.moment[k][lane]);
  }
  add_to_sum(substep, whole_free_impulse(b.joint_blocks[block], lane, impulses), sum.free[lane]);
}

template <class real>
void sum_impulses(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;
  const u32 blocks = b.impulse_sums.empty() ? 0 : b.counters[COUNTER_BLOCKS];
  for (u32 slot = 0; slot < blocks * PACK; ++slot) sum_contacts(b, params.substep, slot / PACK, slot % PACK);
  const u32 joint_blocks = b.joint_sums.empty() ? 0 : params.joint_blocks;
  for (u32 slot = 0; slot < joint_blocks * PACK; ++slot) sum_joint(b, params.substep, slot / PACK, slot % PACK);
}

}  // namespace lockstep::reference
