#pragma OPENCL FP_CONTRACT OFF
// Moves the bodies of each joint back to where it is whole (cpu_reference/close_joints.hpp states the method).
#include "common.h"
#include "joints/factor.h"
#include "joints/joint_now.h"
#include "joints/mobility.h"
#include "sleep.h"
#include "types.h"

static inline real closing_way_into_limits(const Joint joint, real x) {
  if (joint.limited == (real)0 || joint.yield > (real)0) return (real)0;
  return x < joint.low ? joint.low - x : (x > joint.high ? joint.high - x : (real)0);
}

// Bodies that cannot move are never written.
static inline void closing_displace(u32 body, Motion motion, Vec3 x, Quat q, Vec3 impulse, Vec3 moment,
                                    global Vec4* positions, global Vec4* orientations, global u32* counters) {
  if (!(motion.inverse_mass > (real)0)) return;
  x = add3(x, scale3(motion.inverse_mass, impulse));
  q = turn4(q, turn_by(motion, moment), (real)1);
  if (is_bad_pose(x, q)) report_bad(counters, STATUS_BAD_POSE, body);
  Vec4 position = positions[body];
  position.x = x.x;
  position.y = x.y;
  position.z = x.z;
  positions[body] = position;
  orientations[body] = make_vec4(q);
}

static inline void close_joint(u32 bodies, const JointInfo info, const Joint joint, JointSizes sizes,
                               global const Motion* motions, global Vec4* positions, global Vec4* orientations,
                               global u32* counters) {
  if (joint.spring > (real)0) return;
  // the null body stands for the world
  Vec3 x_a = make3((real)0, (real)0, (real)0), x_b = x_a;
  Quat q_a = make4((real)0, (real)0, (real)0, (real)1), q_b = q_a;
  if (info.body_a < bodies) {
    x_a = vec3_of(positions[info.body_a]);
    q_a = quat(orientations[info.body_a]);
  }
  if (info.body_b < bodies) {
    x_b = vec3_of(positions[info.body_b]);
    q_b = quat(orientations[info.body_b]);
  }
  const Motion a = motions[info.body_a], b = motions[info.body_b];
  const JointNow now = joint_now(joint, info.locked, info.free, sizes, x_a, q_a, x_b, q_b);
  real k[JOINT_ROWS][JOINT_ROWS], column[JOINT_ROWS], own;
  joint_mobility(&now, info.free == FREE_ANGLE, a, b, k, column, &own);
  JointFactor factor;
  factorise(k, info.locked, &factor);

  const bool is_free = info.free != FREE_NOTHING;
  real d[JOINT_ROWS], coupling[JOINT_ROWS], response[JOINT_ROWS];
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    const bool locked = (info.locked >> i & 1u) != 0u;
    d[i] = locked ? -now.error[i] : (real)0;
    coupling[i] = locked && is_free ? column[i] : (real)0;
    response[i] = coupling[i];
  }
  solve_factor(&factor, d);
  solve_factor(&factor, response);
  real x = now.coordinate, shared = (real)0;
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    x = x + coupling[i] * d[i];
    shared = shared + coupling[i] * response[i];
  }
  const real e = is_free ? own - shared : (real)0;
  const real d_free = e > (real)0 ? closing_way_into_limits(joint, x) / e : (real)0;
  for (u32 i = 0u; i < JOINT_ROWS; ++i) d[i] = d[i] - response[i] * d_free;

  const bool angular = info.free == FREE_ANGLE;
  Vec3 impulse = add3(add3(scale3(d[0], now.axes[0]), scale3(d[1], now.axes[1])), scale3(d[2], now.axes[2]));
  const real about_z = now.rise != (real)0 ? -(now.rise * d[2]) : d[5];
  Vec3 moment = add3(add3(scale3(d[3], now.axes[0]), scale3(d[4], now.axes[1])), scale3(about_z, now.axes[2]));
  impulse = add3(impulse, scale3(angular ? (real)0 : d_free, now.free_axis));
  moment = add3(moment, scale3(angular ? d_free : (real)0, now.free_axis));
  closing_displace(info.body_a, a, x_a, q_a, scale3((real)-1, impulse),
                   scale3((real)-1, add3(cross3(now.arm_a, impulse), moment)), positions, orientations, counters);
  closing_displace(info.body_b, b, x_b, q_b, impulse, add3(cross3(now.arm_b, impulse), moment), positions, orientations,
                   counters);
}

// One phase: blocks begin .. end - 1, whose joints share no movable body.
kernel void close_joint_phase(const StepParams params, const u32 begin, const u32 end,
                              global const JointLanes* joint_lanes, global const JointInfo* joint_infos,
                              global const Joint* joints, global const real* screw_rises,
                              global const real* rolling_radii, global const Motion* motions,
                              global const Sleeper* sleepers, global Vec4* positions, global Vec4* orientations,
                              global u32* counters) {
  if (STEP_IS_VOID(counters)) return;
  FOR_EACH(slot, (end - begin) * PACK) {
    const u32 index = joint_lanes[begin + slot / PACK].joint[slot % PACK];
    if (index == NONE || joint_sleeps(joint_infos[index], params.bodies, sleepers)) continue;
    close_joint(params.bodies, joint_infos[index], joints[index], joint_sizes(screw_rises, rolling_radii, index),
                motions, positions, orientations, counters);
  }
}

// One work-group: the phases from `first_phase` on; where those are all, every sweep.
kernel void close_joint_tail(const StepParams params, const u32 first_phase, const u32 phases,
                             global const u32* joint_phases, global const JointLanes* joint_lanes,
                             global const JointInfo* joint_infos, global const Joint* joints,
                             global const real* screw_rises, global const real* rolling_radii,
                             global const Motion* motions, global const Sleeper* sleepers, global Vec4* positions,
                             global Vec4* orientations, global u32* counters) {
  const u32 sweeps = first_phase == 0u ? params.position_sweeps : 1u, count = phases - first_phase;
  const u32 visits = STEP_IS_VOID(counters) ? 0u : sweeps * count;
  u32 visit = 0u;
  do {
    const u32 phase = first_phase + visit % count;
    const u32 begin = joint_phases[phase], end = visit < visits ? joint_phases[phase + 1u] : begin;
    for (u32 slot = (u32)get_local_id(0); slot < (end - begin) * PACK; slot += (u32)get_local_size(0)) {
      const u32 index = joint_lanes[begin + slot / PACK].joint[slot % PACK];
      if (index == NONE || joint_sleeps(joint_infos[index], params.bodies, sleepers)) continue;
      close_joint(params.bodies, joint_infos[index], joints[index], joint_sizes(screw_rises, rolling_radii, index),
                  motions, positions, orientations, counters);
    }
    barrier(CLK_GLOBAL_MEM_FENCE);
  } while (++visit < visits);
}
