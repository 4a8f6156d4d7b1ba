// Solves couplings of joints, one in a work-item: what the solver's sweeps and the warm start share.
// cpu_reference/joints/couplings.hpp is the twin and states the method.
#ifndef LOCKSTEP_COUPLINGS_H
#define LOCKSTEP_COUPLINGS_H

#include "rigid_body.h"
#include "solve_contact.h"
#include "sweep_change.h"

#if FEATURE_COUPLINGS

typedef struct CoupledResponse {
  real share, softness, g, e, left;
} CoupledResponse;

static inline Vec3 coupled_vector(global const real (*field)[PACK], u32 lane_index) {
  return make3(field[0][lane_index], field[1][lane_index], field[2][lane_index]);
}

static inline CoupledResponse coupled_response(const u32 purpose, global const JointBlock* block, u32 lane_index) {
  CoupledResponse response;
  response.share = purpose == PURPOSE_RELAX ? block->spring[lane_index] : (real)1;
  response.softness = response.share * block->softness[lane_index];
  response.g = (real)1 / ((real)1 + response.softness);
  const real e = block->free_mobility[lane_index] - response.g * block->coupled_mobility[lane_index];
  response.e = e > (real)0 ? e : (real)0;
  const real compliance = block->impedance_compliance[lane_index];
  response.left = compliance > (real)0 ? compliance / (response.e + compliance) : (real)1;
  return response;
}

// The velocity of b against a at the anchor of b.
static inline Vec3 coupled_slip(global const JointBlock* block, u32 lane_index, Motion a, Motion b) {
  const Vec3 of_b = add3(vec3(b.v), cross3(vec3(b.w), coupled_vector(block->arm_b, lane_index)));
  const Vec3 of_a = add3(vec3(a.v), cross3(vec3(a.w), coupled_vector(block->arm_a, lane_index)));
  return sub3(of_b, of_a);
}

// The velocity of the free coordinate once locked rows and impedance have done what they want.
static inline real coupled_velocity(CoupledResponse response, global const JointBlock* block, u32 free_kind,
                                    u32 lane_index, global const JointImpulseBlock* impulses, Motion a, Motion b) {
  const Vec3 u = coupled_slip(block, lane_index, a, b), w = sub3(vec3(b.w), vec3(a.w));
  real q = dot3(coupled_vector(block->free_axis, lane_index), free_kind == FREE_ANGLE ? w : u);
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    const Vec3 axis = coupled_vector(block->axes + 3u * (i % 3u), lane_index);
    real row = dot3(axis, i < 3u ? u : w) + response.share * block->bias[i][lane_index] +
               block->velocity_product[i][lane_index];
    if (i == 2u && block->lead[lane_index] != (real)0) row = row - block->lead[lane_index] * dot3(axis, w);
    const real wants = block->response[i][lane_index] * row +
                       response.softness * block->coupling[i][lane_index] * impulses->locked[i][lane_index];
    q = q - response.g * wants;
  }
  const real compliance = block->impedance_compliance[lane_index];
  if (!(compliance > (real)0)) return q;
  const real off = q - block->impedance_speed[lane_index] + compliance * impulses->impedance[lane_index];
  return q - ((real)1 - response.left) * off;
}

// What the locked rows answer to an impulse along the free coordinate.
static inline void coupled_locked_impulses(CoupledResponse response, global const JointBlock* block, u32 lane_index,
                                           real r_free, real r[JOINT_ROWS]) {
  for (u32 i = 0u; i < JOINT_ROWS; ++i) r[i] = -(response.g * block->response[i][lane_index] * r_free);
}

// What impulses of the rows push with at b's anchor, and the moment that they have there.
typedef struct CoupledEffort {
  Vec3 impulse, moment;
} CoupledEffort;

static inline CoupledEffort coupled_effort(global const JointBlock* block, u32 free_kind, u32 lane_index,
                                           const real r[JOINT_ROWS], real r_free) {
  const Vec3 x = coupled_vector(block->axes, lane_index), y = coupled_vector(block->axes + 3, lane_index);
  const Vec3 z = coupled_vector(block->axes + 6, lane_index), along = coupled_vector(block->free_axis, lane_index);
  const Vec3 impulse = add3(add3(scale3(r[0], x), scale3(r[1], y)), scale3(r[2], z));
  const real about_z = block->lead[lane_index] != (real)0 ? -(block->lead[lane_index] * r[2]) : r[5];
  const Vec3 moment = add3(add3(scale3(r[3], x), scale3(r[4], y)), scale3(about_z, z));
  const bool angular = free_kind == FREE_ANGLE;
  CoupledEffort effort;
  effort.impulse = add3(impulse, scale3(angular ? (real)0 : r_free, along));
  effort.moment = add3(moment, scale3(angular ? r_free : (real)0, along));
  return effort;
}

static inline void coupled_push_rows(global const JointBlock* block, u32 free_kind, u32 lane_index,
                                     const real r[JOINT_ROWS], real r_free, global Motion* a, global Motion* b) {
  const CoupledEffort effort = coupled_effort(block, free_kind, lane_index, r, r_free);
  Motion of_a = *a, of_b = *b;
  if (of_a.inverse_mass > (real)0) {
    const Vec3 moment = add3(cross3(coupled_vector(block->arm_a, lane_index), effort.impulse), effort.moment);
    store3(of_a.v, sub3(vec3(of_a.v), scale3(of_a.inverse_mass, effort.impulse)));
    store3(of_a.w, sub3(vec3(of_a.w), apply_inverse_inertia(of_a, moment)));
    *a = of_a;
  }
  if (of_b.inverse_mass > (real)0) {
    const Vec3 moment = add3(cross3(coupled_vector(block->arm_b, lane_index), effort.impulse), effort.moment);
    store3(of_b.v, add3(vec3(of_b.v), scale3(of_b.inverse_mass, effort.impulse)));
    store3(of_b.w, add3(vec3(of_b.w), apply_inverse_inertia(of_b, moment)));
    *b = of_b;
  }
}

// Gives the joint so much of the coupling's impulse, and what its locked rows and its impedance answer.
static inline void push_coupled(CoupledResponse response, global const JointBlock* block, u32 free_kind, u32 lane_index,
                                real impulse, global JointImpulseBlock* impulses, global Motion* a, global Motion* b) {
  if (!(response.e > (real)0)) return;
  const real r_free = response.left * impulse;
  real r[JOINT_ROWS];
  coupled_locked_impulses(response, block, lane_index, r_free, r);
  for (u32 i = 0u; i < JOINT_ROWS; ++i) impulses->locked[i][lane_index] = impulses->locked[i][lane_index] + r[i];
  if (block->impedance_compliance[lane_index] > (real)0)
    impulses->impedance[lane_index] = impulses->impedance[lane_index] - ((real)1 - response.left) * impulse;
  coupled_push_rows(block, free_kind, lane_index, r, r_free, a, b);
}

static inline real coupling_bounded_speed(real u, real slowest, real fastest, real bound_softness) {
  if (u < slowest) return u + (slowest - u) / ((real)1 + bound_softness);
  if (u > fastest) return u + (fastest - u) / ((real)1 + bound_softness);
  return u;
}

// The impulses of a coupling that moves at q without them.
static inline CouplingImpulse coupling_impulse(CouplingRow row, bool relaxed, real mobility, real q) {
  const bool sprung = row.compliance > (real)0;
  const real left = sprung ? row.compliance / (mobility + row.compliance) : (real)1;
  const real e = left * mobility, idle = sprung ? row.speed + left * (q - row.speed) : q;
  real slowest = row.slowest, fastest = row.fastest;
  if (relaxed) {
    const bool equal = slowest == fastest;
    slowest = equal || slowest > (real)0 ? (real)0 : slowest;
    fastest = equal || fastest < (real)0 ? (real)0 : fastest;
  }
  const real bound_softness = relaxed ? (real)0 : row.bound_softness;
  CouplingImpulse impulse = {(real)0, (real)0};
  impulse.bound = (coupling_bounded_speed(idle, slowest, fastest, bound_softness) - idle) / e;
  if (sprung) impulse.spring = (row.speed - q - mobility * impulse.bound) / (mobility + row.compliance);
  return impulse;
}

#if FEATURE_TOLERANCE
// The square of by how much a solve changed the velocity of b against a, at b's anchor: u and w are what it was.
static inline real coupled_change(Vec3 u, Vec3 w, global const JointBlock* block, u32 lane_index, Motion a, Motion b) {
  const Vec3 du = sub3(coupled_slip(block, lane_index, a, b), u), dw = sub3(sub3(vec3(b.w), vec3(a.w)), w);
  const real trace = a.inertia_xx + a.inertia_yy + a.inertia_zz + b.inertia_xx + b.inertia_yy + b.inertia_zz;
  return dot3(du, du) + (real)3 * (a.inverse_mass + b.inverse_mass) / trace * dot3(dw, dw);
}
#endif

// What sweeps over couplings read and write.
typedef struct Couplings {
  global const u32* phases;
  global const CouplingInfo* infos;
  global const CoupledJoint* joints;
  global const real* ratios;
  global const CouplingRow* rows;
  global CouplingImpulse* impulses;
  global const JointBlock* joint_blocks;
  global JointImpulseBlock* joint_impulses;
  global Motion* motions;
  global u32* counters;
} Couplings;

#define COUPLINGS                                                                                                     \
  {                                                                                                                   \
    coupling_phases, coupling_infos, coupled_joints, coupling_ratios, coupling_rows, coupling_impulses, joint_blocks, \
        joint_impulses, motions, counters                                                                             \
  }

static inline void solve_coupling(const u32 purpose, u32 index, const Couplings* s) {
  const CouplingRow row = s->rows[index];
  const bool relaxed = purpose == PURPOSE_RELAX;
  const real mobility = relaxed ? row.relaxed_mobility : row.mobility;
  if (!(mobility > (real)0)) return;
  const CouplingInfo info = s->infos[index];
  real u = (real)0;
  for (u32 k = info.first; k < info.first + info.count; ++k) {
    const CoupledJoint joint = s->joints[k];
    const u32 block = joint.slot / PACK, lane_index = joint.slot % PACK;
    global const JointBlock* of_joint = s->joint_blocks + block;
    u = u + s->ratios[k] * coupled_velocity(coupled_response(purpose, of_joint, lane_index), of_joint, joint.free,
                                            lane_index, s->joint_impulses + block, s->motions[joint.body_a],
                                            s->motions[joint.body_b]);
  }
  const real old = s->impulses[index].bound + s->impulses[index].spring;
  const CouplingImpulse impulse = coupling_impulse(row, relaxed, mobility, u - mobility * old);
  s->impulses[index] = impulse;
  const real change = impulse.bound + impulse.spring - old;
  for (u32 k = info.first; k < info.first + info.count; ++k) {
    const CoupledJoint joint = s->joints[k];
    const u32 block = joint.slot / PACK, lane_index = joint.slot % PACK;
    global const JointBlock* of_joint = s->joint_blocks + block;
    global Motion* a = s->motions + joint.body_a;
    global Motion* b = s->motions + joint.body_b;
#if FEATURE_TOLERANCE
    const Motion a_before = *a, b_before = *b;
    const Vec3 before = coupled_slip(of_joint, lane_index, a_before, b_before),
               w = sub3(vec3(b_before.w), vec3(a_before.w));
#endif
    push_coupled(coupled_response(purpose, of_joint, lane_index), of_joint, joint.free, lane_index,
                 s->ratios[k] * change, s->joint_impulses + block, a, b);
#if FEATURE_TOLERANCE
    if (purpose == PURPOSE_SOLVE)
      note_change((lane)coupled_change(before, w, of_joint, lane_index, *a, *b), s->counters);
#endif
  }
}

// One work-group: a sweep over all phases.
static inline void sweep_couplings(const u32 purpose, u32 phases, const Couplings* s) {
  u32 phase = 0u;
  do {
    const u32 begin = s->phases[phase], end = phase < phases ? s->phases[phase + 1u] : begin;
    FOR_EACH_OF_TEAM(k, begin, end) solve_coupling(purpose, k, s);
    TEAM_BARRIER(s->counters);
  } while (++phase < phases);
}

// The same for the warm start.
static inline void start_couplings(u32 phases, global const u32* coupling_phases,
                                   global const CouplingInfo* coupling_infos, global const CoupledJoint* coupled_joints,
                                   global const real* coupling_ratios, global const CouplingImpulse* coupling_impulses,
                                   global const JointBlock* joint_blocks, global Motion* motions,
                                   global const u32* counters) {
  u32 phase = 0u;
  do {
    const u32 begin = coupling_phases[phase], end = phase < phases ? coupling_phases[phase + 1u] : begin;
    FOR_EACH_OF_TEAM(i, begin, end) {
      const real impulse = coupling_impulses[i].bound + coupling_impulses[i].spring;
      const CouplingInfo info = coupling_infos[i];
      for (u32 k = info.first; k < info.first + info.count; ++k) {
        const CoupledJoint joint = coupled_joints[k];
        const real none[JOINT_ROWS] = {(real)0};
        coupled_push_rows(joint_blocks + joint.slot / PACK, joint.free, joint.slot % PACK, none,
                          coupling_ratios[k] * impulse, motions + joint.body_a, motions + joint.body_b);
      }
    }
    TEAM_BARRIER(counters);
  } while (++phase < phases);
}

#endif

#endif
