// A step of LANES joints along the projected gradient. cpu_reference/gradient/gradient_joints.hpp is the twin and
// states the problem.
#ifndef LOCKSTEP_GRADIENT_JOINTS_H
#define LOCKSTEP_GRADIENT_JOINTS_H

#include "gradient/descent.h"
#include "joints/solve_joint.h"

#if FEATURE_JOINTS

// Pairs in contact and joints of a body that can move.
static inline real sides_of(u32 body, u32 bodies, global const BodyInfo* body_infos, global const u32* body_copy_starts,
                            global const u32* joint_side_starts) {
  if (body >= bodies || body_infos[body].kind != BODY_DYNAMIC) return (real)0;
  u32 pairs = 0u;
#if FEATURE_CONTACTS
  pairs = body_copy_starts[body + 1u] - body_copy_starts[body];
#endif
  return (real)(pairs + (joint_side_starts[body + 1u] - joint_side_starts[body]));
}

// Lane `at` of a block begins from the impulses that it has.
static inline void gradient_begin_joint(u32 at, u32 bodies, global const JointLanes* lanes,
                                        global const JointImpulseBlock* r, global const BodyInfo* body_infos,
                                        global const u32* body_copy_starts, global const u32* joint_side_starts,
                                        global GradientJoints* gradient) {
  const real sides_a = sides_of(lanes->body_a[at], bodies, body_infos, body_copy_starts, joint_side_starts);
  const real sides_b = sides_of(lanes->body_b[at], bodies, body_infos, body_copy_starts, joint_side_starts);
  gradient->sides[at] = lanes->joint[at] == NONE ? (real)1 : (sides_a > sides_b ? sides_a : sides_b);
  for (u32 i = 0u; i < JOINT_ROWS; ++i) gradient->next.locked[i][at] = gradient->y.locked[i][at] = r->locked[i][at];
  gradient->next.free[at] = gradient->y.free[at] = r->free[at];
#if FEATURE_JOINT_IMPEDANCES
  gradient->next.impedance[at] = gradient->y.impedance[at] = r->impedance[at];
#endif
}

// The worlds of the joints in lanes first .. first + LANES - 1 of a block; padding counts as of the first.
static inline void worlds_of_joints(u32 first, global const JointLanes* lanes, u32 bodies,
                                    global const BodyInfo* body_infos, u32* worlds) {
  for (u32 k = 0u; k < LANES; ++k) {
    const u32 a = lanes->body_a[first + k], b = lanes->body_b[first + k];
    worlds[k] = a < bodies ? body_infos[a].world : (b < bodies ? body_infos[b].world : 0u);
  }
}

typedef struct LaneJointPush {
  Lane3 impulse, moment_a, moment_b;  // on b, about its centre of mass; of a before the sign
} LaneJointPush;

static inline LaneJointPush lane_joint_push(global const JointBlock* block, lane_mask angular, u32 first, Lane3 arm_a,
                                            Lane3 arm_b, const lane* r, lane r_free) {
  const LaneEffort effort = lane_joint_effort(block, angular, first, r, r_free);
  LaneJointPush push;
  push.impulse = effort.impulse;
  push.moment_a = lane_add3(lane_cross3(arm_a, effort.impulse), effort.moment);
  push.moment_b = lane_add3(lane_cross3(arm_b, effort.impulse), effort.moment);
  return push;
}

static inline lane lane_joint_product(LaneJointPush x, LaneJointPush y, const LaneBody* a, const LaneBody* b) {
  return (a->inverse_mass + b->inverse_mass) * lane_dot3(x.impulse, y.impulse) +
         lane_dot3(x.moment_a, lane_apply_inverse_inertia(*a, y.moment_a)) +
         lane_dot3(x.moment_b, lane_apply_inverse_inertia(*b, y.moment_b));
}

#if FEATURE_TOLERANCE
// As a body at rest would move.
static inline LaneBody lane_moved_by(const LaneBody* body, Lane3 impulse, Lane3 moment) {
  LaneBody moved = *body;
  moved.v = lane_scale3(body->inverse_mass, impulse);
  moved.w = lane_apply_inverse_inertia(*body, moment);
  return moved;
}
#endif

static inline void gradient_step_joints(u32 first, u32 bodies, global const JointLanes* lanes,
                                        global const JointBlock* block, global const JointSideSlots* slots,
                                        global const BodyInfo* body_infos, global const Motion* motions,
                                        global JointImpulseBlock* impulses, global GradientJoints* gradient,
                                        global Velocity* joint_sides, global Descent* descents) {
  u32 worlds[LANES];
  worlds_of_joints(first, lanes, bodies, body_infos, worlds);
  const LaneDescent world = lane_descents(worlds, descents);
  const LaneBody a = lane_load_bodies(motions, lanes->body_a + first);
  const LaneBody b = lane_load_bodies(motions, lanes->body_b + first);
  const lane_mask angular = lane_is_angular(lanes, first);
  const lane_mask there = LANE_MASK(LANE_LOAD_U32(lanes->joint + first) != (lane_u32)NONE);
  lane r[JOINT_ROWS + 1u], y[JOINT_ROWS + 1u], reached[JOINT_ROWS + 1u];
  for (u32 i = 0u; i <= JOINT_ROWS; ++i) {
    const bool is_free = i == JOINT_ROWS;
    const lane old = LANE_LOAD((is_free ? impulses->free : impulses->locked[i]) + first);
    const lane old_y = LANE_LOAD((is_free ? gradient->y.free : gradient->y.locked[i]) + first);
    reached[i] = LANE_LOAD((is_free ? gradient->next.free : gradient->next.locked[i]) + first);
    r[i] = world.moved ? reached[i] : old;
    y[i] = lane_ahead(world.moved, world.beta, reached[i], old, old_y);
  }
#if FEATURE_JOINT_IMPEDANCES
  const lane old_impedance = LANE_LOAD(impulses->impedance + first);
  const lane reached_impedance = LANE_LOAD(gradient->next.impedance + first);
  const lane y_impedance =
      lane_ahead(world.moved, world.beta, reached_impedance, old_impedance, LANE_LOAD(gradient->y.impedance + first));
  LANE_STORE(y_impedance, gradient->y.impedance + first);
  LANE_STORE(world.moved ? reached_impedance : old_impedance, impulses->impedance + first);
#endif

  const lane sides = LANE_LOAD(gradient->sides + first), softness = LANE_LOAD(block->softness + first);
  const lane sigma = sides / world.step;
  const lane g = (lane)1 / (sigma + softness);
  const Lane3 arm_a = lane_joint_vector(block->arm_a, first), arm_b = lane_joint_vector(block->arm_b, first);
  const Lane3 u = lane_velocity_at(arm_b, arm_a, &b, &a), w = lane_sub3(b.w, a.w);
  lane d[JOINT_ROWS];
  lane_solve_locked_rows(block, first, (lane)1, u, w, d);
  lane before = lane_dot3(lane_joint_vector(block->free_axis, first), lane_select3(angular, w, u));
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    d[i] = g * (d[i] - softness * y[i]);
    before = before + sigma * (LANE_LOAD(block->coupling[i] + first) * d[i]);
  }

  const lane old = lane_whole_free_impulse(block, first, y[JOINT_ROWS], gradient->y.impedance);
  const lane free_mobility = LANE_LOAD(block->free_mobility + first),
             coupled_mobility = LANE_LOAD(block->coupled_mobility + first);
  const lane e = sigma * (free_mobility - g * sigma * coupled_mobility);
  const lane q = before - e * old;
  const lane slowest = LANE_LOAD(block->slowest + first), fastest = LANE_LOAD(block->fastest + first);
  const lane own = free_mobility - coupled_mobility / ((lane)1 + softness);
  const LaneFreeRow alone = {e, q}, row = lane_beside_impedance(block, first, alone), own_row = {own, (lane)0};
  const lane unscaled = lane_beside_impedance(block, first, own_row).e;
  const lane bound_softness = LANE_LOAD(block->bound_softness + first) * (unscaled / row.e);
  const lane free_impulse = lane_free_impulse(block, first, row.e, row.q, slowest, fastest, bound_softness);
  const lane r_free = e > (lane)0 ? free_impulse : (lane)0;
#if FEATURE_JOINT_IMPEDANCES
  const lane next_impedance = lane_impedance_impulse(block, first, alone, r_free, y_impedance);
  LANE_STORE(next_impedance, gradient->next.impedance + first);
#endif
  const lane whole = lane_whole_free_impulse(block, first, r_free, gradient->next.impedance), change = whole - old;

  lane ahead[JOINT_ROWS];
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    d[i] = d[i] - g * sigma * LANE_LOAD(block->response[i] + first) * change;
    const lane next = y[i] + d[i];
    ahead[i] = next - r[i];
    LANE_STORE(world.settled ? reached[i] : (there ? next : (lane)0), gradient->next.locked[i] + first);
    LANE_STORE(y[i], gradient->y.locked[i] + first);
    LANE_STORE(r[i], impulses->locked[i] + first);
  }
  LANE_STORE(world.settled ? reached[JOINT_ROWS] : (there ? r_free : (lane)0), gradient->next.free + first);
  LANE_STORE(y[JOINT_ROWS], gradient->y.free + first);
  LANE_STORE(r[JOINT_ROWS], impulses->free + first);
#if FEATURE_JOINT_IMPEDANCES
  LANE_STORE(world.settled ? reached_impedance : (there ? next_impedance : (lane)0), gradient->next.impedance + first);
#endif

  const LaneJointPush push = lane_joint_push(block, angular, first, arm_a, arm_b, d, change);
  const LaneJointPush along =
      lane_joint_push(block, angular, first, arm_a, arm_b, ahead,
                      whole - lane_whole_free_impulse(block, first, r[JOINT_ROWS], impulses->impedance));
  const Lane3 nothing = lane_make3((lane)0, (lane)0, (lane)0);
  LaneStep lane_step;
  lane_step.impulse_a = lane_sub3(nothing, push.impulse);
  lane_step.moment_a = lane_sub3(nothing, push.moment_a);
  lane_step.impulse_b = push.impulse;
  lane_step.moment_b = push.moment_b;
  lane_step.length = sides * lane_joint_product(push, push, &a, &b);
  lane_step.uphill = -(sides * lane_joint_product(push, along, &a, &b));
  lane_step.change = (lane)0;
#if FEATURE_TOLERANCE
  const LaneBody moved_a = lane_moved_by(&a, lane_step.impulse_a, lane_step.moment_a);
  const LaneBody moved_b = lane_moved_by(&b, push.impulse, push.moment_b);
  const lane squared = sigma * sigma * lane_joint_change(nothing, nothing, arm_a, arm_b, &moved_a, &moved_b);
  descent_note((there & !world.settled & (squared > (lane)0)) ? squared : (lane)0, worlds, descents);
#endif
  lane_store_contributions(lane_step, joint_sides, slots->slot_a + first, slots->slot_b + first);
}

// The impulses that the last good step led to.
static inline void gradient_finish_joints(u32 first, u32 bodies, global const JointLanes* lanes,
                                          global const BodyInfo* body_infos, global const GradientJoints* gradient,
                                          global const Descent* descents, global JointImpulseBlock* impulses) {
  u32 worlds[LANES], moved[LANES];
  worlds_of_joints(first, lanes, bodies, body_infos, worlds);
  for (u32 k = 0u; k < LANES; ++k) moved[k] = descents[worlds[k]].moved;
  const lane_mask takes = LANE_MASK(LANE_LOAD_U32(moved) != (lane_u32)0u);
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    const lane next = LANE_LOAD(gradient->next.locked[i] + first), old = LANE_LOAD(impulses->locked[i] + first);
    LANE_STORE(takes ? next : old, impulses->locked[i] + first);
  }
  const lane next = LANE_LOAD(gradient->next.free + first), old = LANE_LOAD(impulses->free + first);
  LANE_STORE(takes ? next : old, impulses->free + first);
#if FEATURE_JOINT_IMPEDANCES
  const lane next_impedance = LANE_LOAD(gradient->next.impedance + first);
  LANE_STORE(takes ? next_impedance : LANE_LOAD(impulses->impedance + first), impulses->impedance + first);
#endif
}

#endif

#endif
