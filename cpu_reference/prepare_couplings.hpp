// Writes the law of each coupling of joints for a sub-step (cpu_reference/joints/couplings.hpp), from what
// prepare_joints wrote of its joints. With L = sum c_i x_i of their free coordinates, at the start of the sub-step:
//   limits   low <= L + dt u <= high while L is between; outside of them, and where low is high, the share `correction`
//            of what L is beyond is taken back, by a velocity; limits that are reached are as soft as joints are, those
//            that lock are hard
//   spring   u + rate (L - rest) + compliance r = 0, as that of a free coordinate (cpu_reference/joints/spring_law.hpp)
// Couplings are not closed by poses: where coordinates grow as their velocities say, as those of hinges and sliders do,
// a coupling that is whole stays so.
#pragma once

#include "cpu_reference/joints/couplings.hpp"
#include "cpu_reference/joints/revolutions.hpp"
#include "cpu_reference/joints/spring_law.hpp"
#include "cpu_reference/measure.hpp"

namespace lockstep::reference {

/// What a unit of the coupling's impulse does to a side of a joint: N s, and N m s about its centre of mass.
template <class real>
struct CoupledPush {
  u32 body;
  Vec3<real> impulse, moment;
};

template <class real>
struct CoupledPushes {
  CoupledPush<real> a, b;
};

template <class real>
CoupledPushes<real> coupled_pushes(Purpose purpose, const JointBlock<real>& block, u32 lane,
                                   const CoupledJoint& joint) {
  const CoupledResponse<real> response = coupled_response(purpose, block, lane);
  real r[JOINT_ROWS];
  coupled_locked_impulses(response, block, lane, response.left, r);
  const auto [impulse, moment] = joint_effort(block, joint.free, lane, r, response.left);
  const Vec3<real> arm_a = joint_vector(block.arm_a, lane), arm_b = joint_vector(block.arm_b, lane);
  return {{joint.body_a, scale3(real(-1), impulse), scale3(real(-1), add3(cross3(arm_a, impulse), moment))},
          {joint.body_b, impulse, add3(cross3(arm_b, impulse), moment)}};
}

/// p M^-1 q where both push one body.
template <class real>
real shared_mobility(const std::vector<Motion<real>>& motions, const CoupledPush<real>& p, const CoupledPush<real>& q) {
  const Motion<real>& body = motions[p.body];
  if (p.body != q.body || !(body.inverse_mass > 0)) return 0;
  return body.inverse_mass * dot3(p.impulse, q.impulse) + dot3(p.moment, apply_inverse_inertia(body, q.moment));
}

/// The velocity of the coupling for a unit of its impulse.
template <class real>
real coupling_mobility(Purpose purpose, const Buffers<real>& b, const CouplingInfo& info) {
  real mobility = 0;
  for (u32 i = info.first; i < info.first + info.count; ++i) {
    const CoupledJoint& joint = b.coupled_joints[i];
    const real ratio = b.coupling_ratios[i];
    const JointBlock<real>& block = b.joint_blocks[joint.slot / PACK];
    const CoupledResponse<real> response = coupled_response(purpose, block, joint.slot % PACK);
    if (!(response.e > 0)) continue;
    mobility = mobility + ratio * ratio * (response.left * response.e);
    const CoupledPushes<real> p = coupled_pushes(purpose, block, joint.slot % PACK, joint);
    for (u32 k = i + 1; k < info.first + info.count; ++k) {
      const CoupledJoint& other = b.coupled_joints[k];
      const JointBlock<real>& other_block = b.joint_blocks[other.slot / PACK];
      if (!(coupled_response(purpose, other_block, other.slot % PACK).e > 0)) continue;
      const CoupledPushes<real> q = coupled_pushes(purpose, other_block, other.slot % PACK, other);
      const real shared = shared_mobility(b.motions, p.a, q.a) + shared_mobility(b.motions, p.a, q.b) +
                          shared_mobility(b.motions, p.b, q.a) + shared_mobility(b.motions, p.b, q.b);
      mobility = mobility + real(2) * ratio * b.coupling_ratios[k] * shared;
    }
  }
  return mobility;
}

/// The free coordinate of a joint at the start of the sub-step, m or rad.
template <class real>
real coupled_coordinate(const Buffers<real>& b, const StepParams<real>& params, u32 index) {
  const JointInfo& info = b.joint_infos[index];
  if (counts_revolutions(b, info)) return b.joint_angles[index];
  Vec3<real> x_a, x_b;
  Quat<real> q_a, q_b;
  joint_pose(b, params, info.body_a, x_a, q_a);
  joint_pose(b, params, info.body_b, x_b, q_b);
  return current_joint(b.joints[index], info, joint_sizes(b, index), x_a, q_a, x_b, q_b).coordinate;
}

/// The velocity of the free coordinate at the start of the sub-step.
template <class real>
real coupled_velocity_before(const Buffers<real>& b, const StepParams<real>& params, const CoupledJoint& joint) {
  const JointBlock<real>& block = b.joint_blocks[joint.slot / PACK];
  const u32 lane = joint.slot % PACK;
  const Velocity<real> before_a = velocity_before(b, params, joint.body_a),
                       before_b = velocity_before(b, params, joint.body_b);
  const Vec3<real> w_a = vec3(before_a.w), w_b = vec3(before_b.w);
  const Vec3<real> u = sub3(add3(vec3(before_b.v), cross3(w_b, joint_vector(block.arm_b, lane))),
                            add3(vec3(before_a.v), cross3(w_a, joint_vector(block.arm_a, lane))));
  return dot3(joint_vector(block.free_axis, lane), joint.free == FREE_ANGLE ? sub3(w_b, w_a) : u);
}

template <class real>
void bound_coupling(const Coupling<real>& coupling, real sum, real dt, CouplingRow<real>& row) {
  const real above = sum - coupling.low, below = coupling.high - sum;
  const real back_down = -correction_speed(coupling.correction * above, true, dt);
  const real back_up = correction_speed(coupling.correction * below, true, dt);
  const bool equal = coupling.low == coupling.high;
  row.slowest = !equal && above > 0 ? -(above / dt) : back_down;
  row.fastest = equal ? back_down : (below > 0 ? below / dt : back_up);
  row.bound_softness = !equal && (above < 0 || below < 0) ? coupling.softness : real(0);
}

template <class real>
void prepare_coupling(Buffers<real>& b, const StepParams<real>& params, u32 index) {
  const Coupling<real>& coupling = b.couplings[index];
  const CouplingInfo& info = b.coupling_infos[index];
  real sum = 0, before = 0;
  for (u32 k = info.first; k < info.first + info.count; ++k) {
    sum = sum + b.coupling_ratios[k] * coupled_coordinate(b, params, b.coupled_joints[k].joint);
    before = before + b.coupling_ratios[k] * coupled_velocity_before(b, params, b.coupled_joints[k]);
  }
  CouplingRow<real> row = {};
  row.mobility = coupling_mobility(Purpose::solve, b, info);
  row.relaxed_mobility = coupling_mobility(Purpose::relax, b, info);
  row.slowest = -real(JOINT_UNBOUNDED);
  row.fastest = real(JOINT_UNBOUNDED);
  if (coupling.limited != 0) bound_coupling(coupling, sum, params.dt, row);
  const real stretch = sum - coupling.rest;
  const SpringLaw<real> spring = spring_law(coupling.rate, coupling.compliance, params, stretch, row.mobility, before);
  row.compliance = spring.compliance;
  row.speed = spring.compliance > 0 ? -spring.bias : real(0);
  b.coupling_rows[index] = row;
  if (params.substep != 0 || !(coupling.compliance > 0)) return;
  const real stiffness = coupling.rate / (coupling.compliance * params.dt);
  add_energy(b.counters, COUNTER_ENERGY,
             energy_units(real(0.5) * stiffness * (stretch * stretch), params.units_per_joule));
}

template <class real>
void prepare_couplings(Buffers<real>& buffers, const StepParams<real>& params) {
  if (step_aborted(buffers.counters)) return;
  for (u32 k = 0; k < buffers.couplings.size(); ++k) prepare_coupling(buffers, params, k);
}

}  // namespace lockstep::reference
