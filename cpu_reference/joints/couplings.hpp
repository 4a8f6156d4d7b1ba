// Solves couplings of joints: what the solver's sweeps and the warm start share. kernels/joints/couplings.h is the
// twin.
//
// A coupling is one row: with the free coordinates x_i of its joints and their ratios c_i, its velocity is
// u = sum c_i x_i', and an impulse r of it pushes each joint along its free coordinate by c_i r (gears, racks, fingers
// that follow each other, tendons that joints wind up: Featherstone, Rigid Body Dynamics Algorithms, 2008, 9.6).
//
// An impulse of a free row moves the locked rows of its joint, and these answer: with K^-1 coupling = response
// (cpu_reference/joints/solve_joint.hpp) by -g response r, g = 1 / (1 + softness). Of armature and what is beside it,
// of compliance z, it leaves z / (e + z), e = free_mobility - g coupled_mobility. Both are eliminated: the row is
// solved with them at once, so that gears converge whatever is heavy, the link or the rotor behind it. With J_i the
// free row less what the locked rows and the impedance answer,
//   u = sum c_i (J_i v + what locked rows and impedances still want),
//   K = sum c_i^2 e_i z_i / (e_i + z_i) + 2 sum c_i c_j J_i M^-1 J_j^T over joints that share bodies.
// It has bounds and a spring: s the velocity at which the spring would not push and y its compliance, as a free row's.
#pragma once

#include "cpu_reference/joints/solve_joint.hpp"

namespace lockstep::reference {

/// How a joint answers to a unit impulse along its free coordinate.
template <class real>
struct CoupledResponse {
  real share;        // of bias and softness that counts
  real softness, g;  // of its locked rows
  real e;            // mobility beside them; 0 where nothing moves
  real left;         // of the impulse, beside an impedance
};

template <class real>
CoupledResponse<real> coupled_response(Purpose purpose, const JointBlock<real>& block, u32 lane) {
  CoupledResponse<real> response;
  response.share = purpose == Purpose::relax ? block.spring[lane] : real(1);
  response.softness = response.share * block.softness[lane];
  response.g = real(1) / (real(1) + response.softness);
  const real e = block.free_mobility[lane] - response.g * block.coupled_mobility[lane];
  response.e = e > 0 ? e : real(0);
  const real compliance = block.impedance_compliance[lane];
  response.left = compliance > 0 ? compliance / (response.e + compliance) : real(1);
  return response;
}

/// The velocity of the free coordinate once locked rows and impedance have done what they want.
template <class real>
real coupled_velocity(const CoupledResponse<real>& response, const JointBlock<real>& block, u32 free, u32 lane,
                      const JointImpulseBlock<real>& impulses, const Motion<real>& a, const Motion<real>& b) {
  const Vec3<real> u = velocity_at(joint_vector(block.arm_b, lane), joint_vector(block.arm_a, lane), b, a);
  const Vec3<real> w = sub3(vec3(b.w), vec3(a.w));
  real q = dot3(joint_vector(block.free_axis, lane), free == FREE_ANGLE ? w : u);
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    const Vec3<real> axis = joint_vector(block.axes + 3 * (i % 3), lane);
    real row = dot3(axis, i < 3 ? u : w) + response.share * block.bias[i][lane] + block.velocity_product[i][lane];
    if (i == 2 && block.lead[lane] != 0) row = row - block.lead[lane] * dot3(axis, w);
    const real wants =
        block.response[i][lane] * row + response.softness * block.coupling[i][lane] * impulses.locked[i][lane];
    q = q - response.g * wants;
  }
  const real compliance = block.impedance_compliance[lane];
  if (!(compliance > 0)) return q;
  const real off = q - block.impedance_speed[lane] + compliance * impulses.impedance[lane];
  return q - (real(1) - response.left) * off;
}

/// What the locked rows answer to an impulse along the free coordinate.
template <class real>
void coupled_locked_impulses(const CoupledResponse<real>& response, const JointBlock<real>& block, u32 lane,
                             real r_free, real (&r)[JOINT_ROWS]) {
  for (u32 i = 0; i < JOINT_ROWS; ++i) r[i] = -(response.g * block.response[i][lane] * r_free);
}

/// Gives the joint so much of the coupling's impulse, and what its locked rows and its impedance answer.
template <class real>
void push_coupled(const CoupledResponse<real>& response, const JointBlock<real>& block, u32 free, u32 lane,
                  real impulse, JointImpulseBlock<real>& impulses, Motion<real>& a, Motion<real>& b) {
  if (!(response.e > 0)) return;
  const real r_free = response.left * impulse;
  real r[JOINT_ROWS];
  coupled_locked_impulses(response, block, lane, r_free, r);
  for (u32 i = 0; i < JOINT_ROWS; ++i) impulses.locked[i][lane] = impulses.locked[i][lane] + r[i];
  if (block.impedance_compliance[lane] > 0)
    impulses.impedance[lane] = impulses.impedance[lane] - (real(1) - response.left) * impulse;
  push_joint(block, free, lane, r, r_free, a, b);
}

/// The impulses of a coupling that moves at q without them: of its bounds and of its spring.
template <class real>
CouplingImpulse<real> coupling_impulse(const CouplingRow<real>& row, bool relaxed, real mobility, real q) {
  const bool sprung = row.compliance > 0;
  const real left = sprung ? row.compliance / (mobility + row.compliance) : real(1);
  const real e = left * mobility, idle = sprung ? row.speed + left * (q - row.speed) : q;
  real slowest = row.slowest, fastest = row.fastest;
  if (relaxed) {  // a bound that excludes rest is a correction
    const bool equal = slowest == fastest;
    slowest = equal || slowest > 0 ? real(0) : slowest;
    fastest = equal || fastest < 0 ? real(0) : fastest;
  }
  const real bound_softness = relaxed ? real(0) : row.bound_softness;
  CouplingImpulse<real> impulse = {0, 0};
  impulse.bound = (bounded_speed(idle, slowest, fastest, bound_softness) - idle) / e;
  if (sprung) impulse.spring = (row.speed - q - mobility * impulse.bound) / (mobility + row.compliance);
  return impulse;
}

/// Calls function(block, lane, joint, ratio) for each of its joints.
template <class real, class Function>
void for_each_coupled(Buffers<real>& b, u32 coupling, Function&& function) {
  const CouplingInfo& info = b.coupling_infos[coupling];
  for (u32 k = info.first; k < info.first + info.count; ++k) {
    const CoupledJoint& joint = b.coupled_joints[k];
    function(joint.slot / PACK, joint.slot % PACK, joint, b.coupling_ratios[k]);
  }
}

/// Returns the square of by how much it changed the relative velocity of a joint's bodies.
template <class real>
real solve_coupling(Purpose purpose, Buffers<real>& buffers, u32 coupling) {
  const CouplingRow<real>& row = buffers.coupling_rows[coupling];
  const bool relaxed = purpose == Purpose::relax;
  const real mobility = relaxed ? row.relaxed_mobility : row.mobility;
  if (!(mobility > 0)) return 0;
  real u = 0;
  for_each_coupled(buffers, coupling, [&](u32 block, u32 lane, const CoupledJoint& joint, real ratio) {
    const JointBlock<real>& of_joint = buffers.joint_blocks[block];
    u = u + ratio * coupled_velocity(coupled_response(purpose, of_joint, lane), of_joint, joint.free, lane,
                                     buffers.joint_impulses[block], buffers.motions[joint.body_a],
                                     buffers.motions[joint.body_b]);
  });
  CouplingImpulse<real>& impulse = buffers.coupling_impulses[coupling];
  const real old = impulse.bound + impulse.spring;
  impulse = coupling_impulse(row, relaxed, mobility, u - mobility * old);
  const real change = impulse.bound + impulse.spring - old;
  real largest = 0;
  for_each_coupled(buffers, coupling, [&](u32 block, u32 lane, const CoupledJoint& joint, real ratio) {
    const JointBlock<real>& of_joint = buffers.joint_blocks[block];
    Motion<real>&a = buffers.motions[joint.body_a], &b = buffers.motions[joint.body_b];
    const Vec3<real> arm_a = joint_vector(of_joint.arm_a, lane), arm_b = joint_vector(of_joint.arm_b, lane);
    const Vec3<real> before = velocity_at(arm_b, arm_a, b, a), w = sub3(vec3(b.w), vec3(a.w));
    push_coupled(coupled_response(purpose, of_joint, lane), of_joint, joint.free, lane, ratio * change,
                 buffers.joint_impulses[block], a, b);
    largest = larger(joint_change(before, w, arm_a, arm_b, a, b), largest);
  });
  return largest;
}

/// One sweep over all couplings, phase after phase. Returns the square of the largest change of a relative velocity.
template <class real>
real sweep_couplings(Purpose purpose, Buffers<real>& buffers) {
  real change = 0;
  for (u32 k = 0; k < buffers.couplings.size(); ++k) change = larger(solve_coupling(purpose, buffers, k), change);
  return change;
}

/// What the locked rows and impedances answered is among their own impulses.
template <class real>
void start_couplings(Buffers<real>& buffers) {
  for (u32 k = 0; k < buffers.couplings.size(); ++k) {
    const real impulse = buffers.coupling_impulses[k].bound + buffers.coupling_impulses[k].spring;
    for_each_coupled(buffers, k, [&](u32 block, u32 lane, const CoupledJoint& joint, real ratio) {
      const real none[JOINT_ROWS] = {};
      push_joint(buffers.joint_blocks[block], joint.free, lane, none, ratio * impulse, buffers.motions[joint.body_a],
                 buffers.motions[joint.body_b]);
    });
  }
}

}  // namespace lockstep::reference
