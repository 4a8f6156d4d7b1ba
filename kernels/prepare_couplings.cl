#pragma OPENCL FP_CONTRACT OFF
// Writes the law of each coupling of joints for a sub-step (cpu_reference/prepare_couplings.hpp states it).
#include "common.h"
#include "energy.h"
#include "joints/couplings.h"
#include "joints/current_joint.h"
#include "joints/revolutions.h"
#include "joints/spring_law.h"
#include "types.h"

// What a unit of the coupling's impulse does to a side of a joint.
typedef struct CoupledPush {
  u32 body;
  Vec3 impulse, moment;
} CoupledPush;

typedef struct CoupledPushes {
  CoupledPush a, b;
} CoupledPushes;

static inline CoupledPushes coupled_pushes(const u32 purpose, global const JointBlock* block, u32 lane_index,
                                           CoupledJoint joint) {
  const CoupledResponse response = coupled_response(purpose, block, lane_index);
  real r[JOINT_ROWS];
  coupled_locked_impulses(response, block, lane_index, response.left, r);
  const CoupledEffort effort = coupled_effort(block, joint.free, lane_index, r, response.left);
  const Vec3 arm_a = coupled_vector(block->arm_a, lane_index), arm_b = coupled_vector(block->arm_b, lane_index);
  CoupledPushes pushes;
  pushes.a.body = joint.body_a;
  pushes.a.impulse = scale3((real)-1, effort.impulse);
  pushes.a.moment = scale3((real)-1, add3(cross3(arm_a, effort.impulse), effort.moment));
  pushes.b.body = joint.body_b;
  pushes.b.impulse = effort.impulse;
  pushes.b.moment = add3(cross3(arm_b, effort.impulse), effort.moment);
  return pushes;
}

// p M^-1 q where both push one body.
static inline real shared_mobility(global const Motion* motions, CoupledPush p, CoupledPush q) {
  const Motion body = motions[p.body];
  if (p.body != q.body || !(body.inverse_mass > (real)0)) return (real)0;
  return body.inverse_mass * dot3(p.impulse, q.impulse) + dot3(p.moment, apply_inverse_inertia(body, q.moment));
}

// The velocity of the coupling for a unit of its impulse.
static inline real coupling_mobility(const u32 purpose, CouplingInfo info, global const CoupledJoint* coupled_joints,
                                     global const real* coupling_ratios, global const JointBlock* joint_blocks,
                                     global const Motion* motions) {
  real mobility = (real)0;
  for (u32 i = info.first; i < info.first + info.count; ++i) {
    const CoupledJoint joint = coupled_joints[i];
    const real ratio = coupling_ratios[i];
    global const JointBlock* block = joint_blocks + joint.slot / PACK;
    const CoupledResponse response = coupled_response(purpose, block, joint.slot % PACK);
    if (!(response.e > (real)0)) continue;
    mobility = mobility + ratio * ratio * (response.left * response.e);
    const CoupledPushes p = coupled_pushes(purpose, block, joint.slot % PACK, joint);
    for (u32 k = i + 1u; k < info.first + info.count; ++k) {
      const CoupledJoint other = coupled_joints[k];
      global const JointBlock* other_block = joint_blocks + other.slot / PACK;
      if (!(coupled_response(purpose, other_block, other.slot % PACK).e > (real)0)) continue;
      const CoupledPushes q = coupled_pushes(purpose, other_block, other.slot % PACK, other);
      const real shared = shared_mobility(motions, p.a, q.a) + shared_mobility(motions, p.a, q.b) +
                          shared_mobility(motions, p.b, q.a) + shared_mobility(motions, p.b, q.b);
      mobility = mobility + (real)2 * ratio * coupling_ratios[k] * shared;
    }
  }
  return mobility;
}

#if FEATURE_JOINTS_AHEAD
// The velocity of the free coordinate at the start of the sub-step.
static inline real coupled_velocity_before(CoupledJoint joint, u32 bodies, global const JointBlock* block,
                                           global const Velocity* previous_velocities) {
  const u32 lane_index = joint.slot % PACK;
  const Velocity before_a = joint_velocity_before(joint.body_a, bodies, previous_velocities);
  const Velocity before_b = joint_velocity_before(joint.body_b, bodies, previous_velocities);
  const Vec3 w_a = vec3(before_a.w), w_b = vec3(before_b.w);
  const Vec3 u = sub3(add3(vec3(before_b.v), cross3(w_b, coupled_vector(block->arm_b, lane_index))),
                      add3(vec3(before_a.v), cross3(w_a, coupled_vector(block->arm_a, lane_index))));
  return dot3(coupled_vector(block->free_axis, lane_index), joint.free == FREE_ANGLE ? sub3(w_b, w_a) : u);
}
#endif

static inline void bound_coupling(Coupling coupling, real sum, real dt, CouplingRow* row) {
  const real above = sum - coupling.low, below = coupling.high - sum;
  const real back_down = -joint_correction_speed(coupling.correction * above, true, dt);
  const real back_up = joint_correction_speed(coupling.correction * below, true, dt);
  const bool equal = coupling.low == coupling.high;
  row->slowest = !equal && above > (real)0 ? -(above / dt) : back_down;
  row->fastest = equal ? back_down : (below > (real)0 ? below / dt : back_up);
  row->bound_softness = !equal && (above < (real)0 || below < (real)0) ? coupling.softness : (real)0;
}

kernel void prepare_couplings(const StepParams params, const u32 coupling_count, global const Vec4* positions,
                              global const Vec4* orientations, global const Velocity* previous_velocities,
                              global const Motion* motions, global const JointInfo* joint_infos,
                              global const Joint* joints, global const real* screw_leads,
                              global const real* rolling_radii, global const real* joint_angles,
                              global const JointBlock* joint_blocks, global const Coupling* couplings,
                              global const CouplingInfo* coupling_infos, global const CoupledJoint* coupled_joints,
                              global const real* coupling_ratios, global CouplingRow* coupling_rows,
                              global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  long energy = 0;
  FOR_EACH(index, coupling_count) {
    const Coupling coupling = couplings[index];
    const CouplingInfo info = coupling_infos[index];
    real sum = (real)0, before = (real)0;
    for (u32 k = info.first; k < info.first + info.count; ++k) {
      const CoupledJoint joint = coupled_joints[k];
      const JointInfo of_joint = joint_infos[joint.joint];
      real coordinate = (real)0;
      if (counts_revolutions(of_joint)) {
        coordinate = joint_angles[joint.joint];
      } else {
        Vec3 x_a, x_b;
        Quat q_a, q_b;
        joint_pose(joint.body_a, params.bodies, positions, orientations, &x_a, &q_a);
        joint_pose(joint.body_b, params.bodies, positions, orientations, &x_b, &q_b);
        coordinate = current_joint(joints[joint.joint], of_joint.locked, of_joint.free,
                                   joint_sizes(screw_leads, rolling_radii, joint.joint), x_a, q_a, x_b, q_b)
                         .coordinate;
      }
      sum = sum + coupling_ratios[k] * coordinate;
#if FEATURE_JOINTS_AHEAD
      before =
          before + coupling_ratios[k] * coupled_velocity_before(joint, params.bodies, joint_blocks + joint.slot / PACK,
                                                                previous_velocities);
#endif
    }
    CouplingRow row;
    row.mobility = coupling_mobility(PURPOSE_SOLVE, info, coupled_joints, coupling_ratios, joint_blocks, motions);
    row.relaxed_mobility =
        coupling_mobility(PURPOSE_RELAX, info, coupled_joints, coupling_ratios, joint_blocks, motions);
    row.slowest = -(real)JOINT_UNBOUNDED;
    row.fastest = (real)JOINT_UNBOUNDED;
    row.bound_softness = (real)0;
    row.pad = (real)0;
    if (coupling.limited != (real)0) bound_coupling(coupling, sum, params.dt, &row);
    const real stretch = sum - coupling.rest;
    const SpringLaw spring =
        joint_spring_law(coupling.rate, coupling.compliance, &params, stretch, row.mobility, before);
    row.compliance = spring.compliance;
    row.speed = spring.compliance > (real)0 ? -spring.bias : (real)0;
    coupling_rows[index] = row;
    if (params.substep != 0u || !(coupling.compliance > (real)0)) continue;
    const real stiffness = coupling.rate / (coupling.compliance * params.dt);
    energy += energy_units((real)0.5 * stiffness * (stretch * stretch), params.units_per_joule);
  }
  if (params.substep == 0u) add_energy(counters, COUNTER_ENERGY, energy);
}
