// Solves LANES joints of one colour: what the solver's sweeps and the warm start share.
// cpu_reference/joints/solve_joint.hpp is the twin and states the method.
#ifndef LOCKSTEP_SOLVE_JOINT_H
#define LOCKSTEP_SOLVE_JOINT_H

#include "joints/factor.h"
#include "solve_contact.h"

#if FEATURE_JOINTS

static inline Lane3 lane_joint_vector(global const real (*field)[PACK], u32 first) {
  return lane_make3(LANE_LOAD(field[0] + first), LANE_LOAD(field[1] + first), LANE_LOAD(field[2] + first));
}

// Replaces b by K^-1 b.
static inline void lane_solve_factor(global const JointBlock* block, u32 first, lane b[JOINT_ROWS]) {
  lane lower[JOINT_LOWER];
  for (u32 i = 0u; i < JOINT_LOWER; ++i) lower[i] = LANE_LOAD(block->lower[i] + first);
  for (u32 i = 1u; i < JOINT_ROWS; ++i) {
    for (u32 n = 0u; n < i; ++n) b[i] = b[i] - lower[LOWER_INDEX(i, n)] * b[n];
  }
  for (u32 i = 0u; i < JOINT_ROWS; ++i) b[i] = b[i] * LANE_LOAD(block->inverse_pivot[i] + first);
  for (u32 i = JOINT_ROWS - 1u; i-- > 0u;) {
    for (u32 n = i + 1u; n < JOINT_ROWS; ++n) b[i] = b[i] - lower[LOWER_INDEX(n, i)] * b[n];
  }
}

// What impulses of the rows push with at b's anchor, and the moment that they have there.
typedef struct LaneEffort {
  Lane3 impulse, moment;
} LaneEffort;

static inline LaneEffort lane_joint_effort(global const JointBlock* block, lane_mask angular, u32 first, const lane* r,
                                           lane r_free) {
  const Lane3 x = lane_joint_vector(block->axes, first), y = lane_joint_vector(block->axes + 3, first);
  const Lane3 z = lane_joint_vector(block->axes + 6, first), along = lane_joint_vector(block->free_axis, first);
  LaneEffort effort;
  effort.impulse = lane_add3(lane_add3(lane_scale3(r[0], x), lane_scale3(r[1], y)), lane_scale3(r[2], z));
  lane about_z = r[5];
#if FEATURE_SCREWS
  const lane lead = LANE_LOAD(block->lead + first);
  about_z = lead != (lane)0 ? -(lead * r[2]) : about_z;
#endif
  effort.moment = lane_add3(lane_add3(lane_scale3(r[3], x), lane_scale3(r[4], y)), lane_scale3(about_z, z));
  effort.impulse = lane_add3(effort.impulse, lane_scale3(angular ? (lane)0 : r_free, along));
  effort.moment = lane_add3(effort.moment, lane_scale3(angular ? r_free : (lane)0, along));
  return effort;
}

// Impulses of the rows on b, their opposite on a.
static inline void lane_push_joint(global const JointBlock* block, lane_mask angular, u32 first, const lane* r,
                                   lane r_free, LaneBody* a, LaneBody* b) {
  const LaneEffort effort = lane_joint_effort(block, angular, first, r, r_free);
  const Lane3 impulse = effort.impulse, moment = effort.moment;
  const Lane3 arm_a = lane_joint_vector(block->arm_a, first), arm_b = lane_joint_vector(block->arm_b, first);
  a->v = lane_sub3(a->v, lane_scale3(a->inverse_mass, impulse));
  a->w = lane_sub3(a->w, lane_apply_inverse_inertia(*a, lane_add3(lane_cross3(arm_a, impulse), moment)));
  b->v = lane_add3(b->v, lane_scale3(b->inverse_mass, impulse));
  b->w = lane_add3(b->w, lane_apply_inverse_inertia(*b, lane_add3(lane_cross3(arm_b, impulse), moment)));
}

static inline lane lane_bounded_speed(lane u, lane slowest, lane fastest, lane bound_softness) {
  const lane faster = u + (slowest - u) / ((lane)1 + bound_softness),
             slower = u + (fastest - u) / ((lane)1 + bound_softness);
  return u < slowest ? faster : (u > fastest ? slower : u);
}

// Fills d with what the locked rows alone would change their impulses by, were they hard.
static inline void lane_solve_locked_rows(global const JointBlock* block, u32 first, lane share, Lane3 u, Lane3 w,
                                          lane d[JOINT_ROWS]) {
  for (u32 i = 0u; i < 3u; ++i) {
    const Lane3 axis = lane_joint_vector(block->axes + 3u * i, first);
    d[i] = -(lane_dot3(axis, u) + share * LANE_LOAD(block->bias[i] + first) +
             LANE_LOAD(block->velocity_product[i] + first));
    d[i + 3u] = -(lane_dot3(axis, w) + share * LANE_LOAD(block->bias[i + 3u] + first) +
                  LANE_LOAD(block->velocity_product[i + 3u] + first));
  }
#if FEATURE_SCREWS
  const lane lead = LANE_LOAD(block->lead + first);
  d[2] = lead != (lane)0 ? d[2] + lead * lane_dot3(lane_joint_vector(block->axes + 6, first), w) : d[2];
#endif
  lane_solve_factor(block, first, d);
}

// All that the free row pushes with.
static inline lane lane_whole_free_impulse(global const JointBlock* block, u32 first, lane free,
                                           global const real* impedance) {
#if FEATURE_JOINT_IMPEDANCES
  const lane_mask has = LANE_LOAD(block->impedance_compliance + first) > (lane)0;
  return has ? free + LANE_LOAD(impedance + first) : free;
#else
  return free;
#endif
}

// How easily the free row moves, and at what velocity without an impulse of its own.
typedef struct LaneFreeRow {
  lane e, q;
} LaneFreeRow;

// The same beside the joint's impedance, which answers.
static inline LaneFreeRow lane_beside_impedance(global const JointBlock* block, u32 first, LaneFreeRow row) {
#if FEATURE_JOINT_IMPEDANCES
  const lane compliance = LANE_LOAD(block->impedance_compliance + first);
  const lane speed = LANE_LOAD(block->impedance_speed + first);
  const lane left = compliance / (row.e + compliance);
  const lane e = left * row.e, q = speed + left * (row.q - speed);
  row.e = compliance > (lane)0 ? e : row.e;
  row.q = compliance > (lane)0 ? q : row.q;
#endif
  return row;
}

#if FEATURE_JOINT_IMPEDANCES
// The impulse that an impedance has beside one of r_free, where it had `old`.
static inline lane lane_impedance_impulse(global const JointBlock* block, u32 first, LaneFreeRow row, lane r_free,
                                          lane old) {
  const lane compliance = LANE_LOAD(block->impedance_compliance + first);
  const lane answer = (LANE_LOAD(block->impedance_speed + first) - row.q - row.e * r_free) / (row.e + compliance);
  return ((row.e > (lane)0) & (compliance > (lane)0)) ? answer : old;
}
#endif

// The impulse that the free row gets, where e is not 0.
static inline lane lane_free_impulse(global const JointBlock* block, u32 first, lane e, lane q, lane slowest,
                                     lane fastest, lane bound_softness) {
  const lane motor_impulse = LANE_LOAD(block->motor_impulse + first), wanted = LANE_LOAD(block->motor_speed + first);
  lane idle = q, motor_change = e * motor_impulse;
#if FEATURE_JOINT_SPRINGS
  const lane spring_compliance = LANE_LOAD(block->spring_compliance + first);
  const lane_mask sprung = spring_compliance > (lane)0;
  const lane left = sprung ? spring_compliance / (e + spring_compliance) : (lane)1;
  idle = sprung ? slowest + left * (q - slowest) : q;
  motor_change = left * motor_change;
#endif
  const lane_mask brakes = wanted<idle - motor_change, pushes = wanted> idle + motor_change;
  const lane driven = brakes ? idle - motor_change : (pushes ? idle + motor_change : wanted);
  const lane hard = (lane_bounded_speed(driven, slowest, fastest, bound_softness) - q) / e;
#if FEATURE_JOINT_SPRINGS
  const lane alone = (slowest - q) / (e + spring_compliance), motor = left * motor_impulse;
  const lane beside = brakes ? alone - motor : (pushes ? alone + motor : (wanted - q) / e);
  const lane least = wanted + motor_impulse, most = wanted - motor_impulse;  // of a spring of bounded force
  const lane bounded = alone < least ? least : (alone > most ? most : alone);
  const lane soft = motor_impulse > (lane)0 ? beside : (motor_impulse < (lane)0 ? bounded : alone);
  return sprung ? soft : hard;
#else
  return hard;
#endif
}

static inline lane_mask lane_is_angular(global const JointLanes* lanes, u32 first) {
  return LANE_MASK(LANE_LOAD_U32(lanes->free + first) == (lane_u32)FREE_ANGLE);
}

#if FEATURE_TOLERANCE
// The square of by how much a solve changed the velocity of b against a, at b's anchor: u and w are what it was. A
// rotation counts at a radius of gyration of the two bodies.
static inline lane lane_joint_change(Lane3 u, Lane3 w, Lane3 arm_a, Lane3 arm_b, const LaneBody* a, const LaneBody* b) {
  const Lane3 du = lane_sub3(lane_velocity_at(arm_b, arm_a, b, a), u);
  const Lane3 dw = lane_sub3(lane_sub3(b->w, a->w), w);
  const lane trace = a->xx + a->yy + a->zz + b->xx + b->yy + b->zz;
  return lane_dot3(du, du) + (lane)3 * (a->inverse_mass + b->inverse_mass) / trace * lane_dot3(dw, dw);
}
#endif

// One Gauss-Seidel solve of the joints in lanes first .. first + LANES - 1 of a block.
static inline void solve_joint_lanes(const u32 purpose, u32 first, global const JointLanes* lanes,
                                     global const JointBlock* block, global JointImpulseBlock* impulses,
                                     global Motion* motions, global u32* counters) {
  LaneBody a = lane_load_bodies(motions, lanes->body_a + first), b = lane_load_bodies(motions, lanes->body_b + first);
  const lane_mask angular = lane_is_angular(lanes, first);
  const lane spring = LANE_LOAD(block->spring + first);
  const lane share = purpose == PURPOSE_RELAX ? spring : (lane)1;
  const lane softness = share * LANE_LOAD(block->softness + first);
  const lane g = (lane)1 / ((lane)1 + softness);
  lane slowest = LANE_LOAD(block->slowest + first), fastest = LANE_LOAD(block->fastest + first);
  if (purpose == PURPOSE_RELAX) {
    lane_mask kept = spring > (lane)0;
    const lane_mask equal = slowest == fastest;
#if FEATURE_JOINT_SPRINGS
    kept = kept | (LANE_LOAD(block->spring_compliance + first) > (lane)0);
#endif
    const lane still = -LANE_LOAD(block->velocity_product[JOINT_ROWS] + first);
    slowest = kept ? slowest : (equal ? still : (slowest > (lane)0 ? (lane)0 : slowest));
    fastest = kept ? fastest : (equal ? still : (fastest < (lane)0 ? (lane)0 : fastest));
  }

  const Lane3 arm_a = lane_joint_vector(block->arm_a, first), arm_b = lane_joint_vector(block->arm_b, first);
  const Lane3 u = lane_velocity_at(arm_b, arm_a, &b, &a), w = lane_sub3(b.w, a.w);
  lane d[JOINT_ROWS];
  lane_solve_locked_rows(block, first, share, u, w, d);
  lane before = lane_dot3(lane_joint_vector(block->free_axis, first), lane_select3(angular, w, u));
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    d[i] = g * (d[i] - softness * LANE_LOAD(impulses->locked[i] + first));
    before = before + LANE_LOAD(block->coupling[i] + first) * d[i];
  }

  const lane old = LANE_LOAD(impulses->free + first);
  const lane old_whole = lane_whole_free_impulse(block, first, old, impulses->impedance);
  const lane e = LANE_LOAD(block->free_mobility + first) - g * LANE_LOAD(block->coupled_mobility + first);
  const LaneFreeRow alone = {e, before - e * old_whole}, row = lane_beside_impedance(block, first, alone);
  const lane bound_softness = share * LANE_LOAD(block->bound_softness + first);
  const lane free_impulse = lane_free_impulse(block, first, row.e, row.q, slowest, fastest, bound_softness);
  lane r_free = e > (lane)0 ? free_impulse : (lane)0;
#if FEATURE_SLEEPING
  r_free = LANE_LOAD(block->free_mobility + first) > (lane)0 ? r_free : old;  // of a joint that sleeps
#endif
#if FEATURE_JOINT_IMPEDANCES
  const lane impedance = LANE_LOAD(impulses->impedance + first);
  LANE_STORE(lane_impedance_impulse(block, first, alone, r_free, impedance), impulses->impedance + first);
#endif
  const lane change = lane_whole_free_impulse(block, first, r_free, impulses->impedance) - old_whole;

  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    d[i] = d[i] - g * LANE_LOAD(block->response[i] + first) * change;
    LANE_STORE(LANE_LOAD(impulses->locked[i] + first) + d[i], impulses->locked[i] + first);
  }
  LANE_STORE(r_free, impulses->free + first);
  lane_push_joint(block, angular, first, d, change, &a, &b);
#if FEATURE_TOLERANCE
  if (purpose == PURPOSE_SOLVE)
    note_change(lane_larger(lane_joint_change(u, w, arm_a, arm_b, &a, &b), (lane)0), counters);
#endif
  lane_store_bodies(a, motions, lanes->body_a + first);
  lane_store_bodies(b, motions, lanes->body_b + first);
}

// Gives the bodies the impulses that the joints start from.
static inline void start_joints(u32 first, global const JointLanes* lanes, global const JointBlock* block,
                                global const JointImpulseBlock* impulses, global Motion* motions) {
  LaneBody a = lane_load_bodies(motions, lanes->body_a + first), b = lane_load_bodies(motions, lanes->body_b + first);
  lane r[JOINT_ROWS];
  for (u32 i = 0u; i < JOINT_ROWS; ++i) r[i] = LANE_LOAD(impulses->locked[i] + first);
  const lane r_free = lane_whole_free_impulse(block, first, LANE_LOAD(impulses->free + first), impulses->impedance);
  lane_push_joint(block, lane_is_angular(lanes, first), first, r, r_free, &a, &b);
  lane_store_bodies(a, motions, lanes->body_a + first);
  lane_store_bodies(b, motions, lanes->body_b + first);
}

// One phase: blocks begin .. end - 1.
static inline void sweep_joint_phase(const u32 purpose, u32 begin, u32 end, global const JointLanes* joint_lanes,
                                     global const JointBlock* joint_blocks, global JointImpulseBlock* joint_impulses,
                                     global Motion* motions, global u32* counters) {
  FOR_EACH(item, (end - begin) * ITEMS_PER_BLOCK) {
    const u32 block = begin + item / ITEMS_PER_BLOCK;
    solve_joint_lanes(purpose, item % ITEMS_PER_BLOCK * LANES, joint_lanes + block, joint_blocks + block,
                      joint_impulses + block, motions, counters);
  }
}

// One work-group: a sweep over the phases from `first_phase` on.
static inline void sweep_joints(const u32 purpose, u32 first_phase, u32 phases, global const u32* joint_phases,
                                global const JointLanes* joint_lanes, global const JointBlock* joint_blocks,
                                global JointImpulseBlock* joint_impulses, global Motion* motions,
                                global u32* counters) {
  u32 phase = first_phase;
  do {
    const u32 begin = joint_phases[phase], end = phase < phases ? joint_phases[phase + 1u] : begin;
    const u32 items = (end - begin) * ITEMS_PER_BLOCK;
    FOR_EACH_OF_TEAM(item, 0u, items) {
      const u32 block = begin + item / ITEMS_PER_BLOCK;
      solve_joint_lanes(purpose, item % ITEMS_PER_BLOCK * LANES, joint_lanes + block, joint_blocks + block,
                        joint_impulses + block, motions, counters);
    }
    TEAM_BARRIER(counters);
  } while (++phase < phases);
}

// The same for the warm start.
static inline void start_joint_phases(u32 first_phase, u32 phases, global const u32* joint_phases,
                                      global const JointLanes* joint_lanes, global const JointBlock* joint_blocks,
                                      global const JointImpulseBlock* joint_impulses, global Motion* motions,
                                      global const u32* counters) {
  u32 phase = first_phase;
  do {
    const u32 begin = joint_phases[phase], end = phase < phases ? joint_phases[phase + 1u] : begin;
    const u32 items = (end - begin) * ITEMS_PER_BLOCK;
    FOR_EACH_OF_TEAM(item, 0u, items) {
      const u32 block = begin + item / ITEMS_PER_BLOCK;
      start_joints(item % ITEMS_PER_BLOCK * LANES, joint_lanes + block, joint_blocks + block, joint_impulses + block,
                   motions);
    }
    TEAM_BARRIER(counters);
  } while (++phase < phases);
}

#endif

#endif
