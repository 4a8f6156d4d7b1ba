// Writes the law of each joint for a sub-step. With u the velocities of the locked rows, b against a in the joint's
// frame, and r their impulses (survey 2.2; K = J M^-1 J^T of the joint alone):
//   u + correction error / dt + dt/2 u' + softness K r = 0
// Hard joints (softness 0) take nothing back: they are closed by poses once the bodies have moved
// (cpu_reference/close_joints.hpp); or a share of the error, by a velocity that stays (Baumgarte). Soft ones are damped
// springs (Catto, Soft Constraints, GDC 2011), whose push is relaxed after the bodies have moved.
//
// u' is the rate at which the velocity of a row would change if the bodies went on with their velocities, those of the
// start of the sub-step: the anchors run on circles and the axes turn. What forces have done since is no velocity that
// the joints allow: a torque about a hinge far from the centre of mass rotates the body as if it were free. Where it is
// counted the error of a step is of third order, and energy stays: at theta 1 the positions are those of SHAKE
// (Ryckaert, Ciccotti, Berendsen 1977). The axes and arms are those at (1 - theta) dt, when what the old velocities
// move is done: at theta 1/2 in the middle of the step, between the velocities that the impulses tell apart. Along the
// axes of its start what swings would gain energy at each step, in first order. The error and the free coordinate are
// those of the start. There the impulses do no work where the mean of the old and the new velocity is along what is
// free, J_mid (v_old + v_new) = 0. J_mid v_old is dt/2 u' but for terms of higher order, and all of it would hand on
// what the last step left unsolved, with the other sign: half of each is taken, and the error of energy is half as
// large. Where a body turns by a radian in the step there is nothing to foresee, and less of either is taken: dt is
// divided by 1 + dt^2 (w_a^2 + w_b^2).
//
// The row of z of a screw is that of its thread, u_z - lead w_z, its impulse a force and a moment in one. The axes of a
// universal joint are those of its cross, which turns against a with w_z about z.
//
// The free coordinate x has one more row, with velocity u_f and impulse r_f = r_m + r_l:
//   motor    u_f = motor_speed as far as |r_m| <= motor_force dt reaches; dry friction is a motor of speed 0
//   limits   low <= x + dt u_f <= high while x is between; outside of them a share of what x is beyond is taken back
//   spring   r_l = -h (k (x + theta h u_f - rest) + c u_f), that is u_f + rate (x - rest) + compliance r_l = 0, with
//            compliance = 1 / (h (theta h k + c)) and rate = h k compliance (host/scene/compile_joints.cpp). At theta
//            1/2 it keeps its energy at any stiffness: the map of one oscillation has determinant 1 and trace
//            2 / (1 + h^2 k / 2 m). A damper there takes c ((1 - t) u_0 + t u_f), u_0 the velocity at the start of the
//            sub-step: with t 1/2 it is of second order and rings where it is stiff, with t = (z + 3) / (z + 6), z =
//            h c / m, it is of the same order and does not (t goes to 1)
//   armature r_i = -a (change of the rate of x over the sub-step), that is u_f - s + r_i / a = 0 with s = u_0 - h u_f',
//            u_0 at the start of the sub-step: inertia a along the coordinate between the two bodies. A spring beside
//            it, or beside limits, is in one row with it: both push with u_f, so that 1 / compliance and s / compliance
//            add
// Limits, or the spring, are `slowest <= u_f <= fastest` in the solve (cpu_reference/joints/solve_joint.hpp), which
// solves the row together with the locked ones: `coupling` is what its impulse does to them, `response` what they
// answer.
#pragma once

#include "cpu_reference/joints/current_joint.hpp"
#include "cpu_reference/joints/factor.hpp"
#include "cpu_reference/joints/mobility.hpp"
#include "cpu_reference/joints/revolutions.hpp"
#include "cpu_reference/joints/solve_joint.hpp"
#include "cpu_reference/joints/spring_law.hpp"
#include "cpu_reference/measure.hpp"
#include "cpu_reference/sleep.hpp"

namespace lockstep::reference {

/// The row of armature and of the spring beside it: u_f + bias + compliance r_i = 0. Without either compliance is 0.
/// `before`: the velocity at which armature would not push.
template <class real>
SpringLaw<real> impedance_law(real armature, SpringLaw<real> spring, real before) {
  if (!(armature > 0)) return spring;
  const real compliance = real(1) / armature;
  if (!(spring.compliance > 0)) return {-before, compliance};
  const real both = spring.compliance + compliance, of_armature = spring.compliance / both;
  return {compliance / both * spring.bias - of_armature * before, of_armature * compliance};
}

template <class real>
struct FreeLaw {
  real slowest, fastest, bound_softness;
};

/// `velocity_product` is what the rotation of the bodies adds to the velocity: only a locked coordinate asks.
template <class real>
FreeLaw<real> free_law(const Joint<real>& joint, real x, SpringLaw<real> spring, bool counted, real velocity_product,
                       real dt) {
  FreeLaw<real> law = {-real(JOINT_UNBOUNDED), real(JOINT_UNBOUNDED), 0};
  if (joint.limited == 0) return law;
  if (joint.spring_compliance > 0) {
    law.slowest = -spring.bias;
    law.fastest = law.slowest;
    return law;
  }
  const real above = x - joint.low, below = joint.high - x;
  if (joint.low == joint.high) {
    law.slowest = -(correction_speed(joint.correction * above, counted, dt) + velocity_product);
    law.fastest = law.slowest;
    law.bound_softness = joint.softness;
    return law;
  }
  law.slowest = above > 0 ? -(above / dt) : -correction_speed(joint.correction * above, counted, dt);
  law.fastest = below > 0 ? below / dt : correction_speed(joint.correction * below, counted, dt);
  law.bound_softness = above < 0 || below < 0 ? joint.softness : real(0);
  return law;
}

/// The velocities that are foreseen with: those of the start of the sub-step, since what forces did to a body since
/// then its joints may not allow; of a damped body those that are left to it.
template <class real>
Velocity<real> foreseen_velocity(const Buffers<real>& buffers, const StepParams<real>& params, u32 body) {
  const Velocity<real> before = velocity_before(buffers, params, body);
  if (!(before.damped > real(0))) return before;
  return make_velocity(vec3(buffers.motions[body].v), vec3(buffers.motions[body].w));
}

/// The rate u' of each row at these velocities; the last is that of the free row. With the anchor of b at d from
/// that of a, in the frame that turns with a: d' = u and d'' = w_b x (w_b x arm_b) - w_a x (w_a x arm_a) - 2 w_a x u.
/// With w = w_b - w_a, the rows of a skate turn with b instead, which takes w x u off; the part of the arms of what
/// rolls that goes down to where it touches turns with a, which takes w x (w x down) off.
template <class real>
void row_rates(const CurrentJoint<real>& current, const JointInfo& info, const Velocity<real>& a,
               const Velocity<real>& b, real (&rates)[JOINT_ROWS + 1]) {
  const Vec3<real> w_a = vec3(a.w), w_b = vec3(b.w);
  const Vec3<real> on_a = cross3(w_a, current.arm_a), on_b = cross3(w_b, current.arm_b);
  const Vec3<real> u = sub3(add3(vec3(b.v), on_b), add3(vec3(a.v), on_a));
  Vec3<real> rate = sub3(sub3(cross3(w_b, on_b), cross3(w_a, on_a)), scale3(real(2), cross3(w_a, u)));
  const Vec3<real> w = sub3(w_b, w_a);
  if (LOCKS_SKATE(info.locked)) rate = sub3(rate, cross3(w, u));
  if (current.radius > 0) rate = sub3(rate, cross3(w, cross3(w, scale3(-current.radius, current.axes[2]))));
  const bool crosses = LOCKS_CROSS(info.locked);
  const Vec3<real> w_axes = crosses ? add3(w_a, scale3(dot3(current.axes[2], w), current.axes[2])) : w_a;
  const Vec3<real> angular_rate = cross3(w, w_axes);
  for (u32 i = 0; i < 3; ++i) {
    rates[i] = dot3(current.axes[i], rate);
    rates[i + 3] = dot3(current.axes[i], angular_rate);
  }
  if (current.lead != 0) rates[2] = rates[2] - current.lead * rates[5];
  rates[JOINT_ROWS] = dot3(current.free_axis, info.free == FREE_ANGLE ? angular_rate : rate);
  if (info.free == FREE_LENGTH && current.coordinate > 0) {  // the direction turns too
    const real along = dot3(current.free_axis, u);
    rates[JOINT_ROWS] = rates[JOINT_ROWS] + (dot3(u, u) - along * along) / current.coordinate;
  }
}

/// All that follows from the geometry; that of padding, and of joints that sleep, is zero: a solve changes nothing.
template <class real>
void write_joint(JointBlock<real>& block, u32 lane, const CurrentJoint<real>& current, const JointFactor<real>& factor,
                 const real (&bias)[JOINT_ROWS], const real (&velocity_product)[JOINT_ROWS + 1],
                 const real (&coupling)[JOINT_ROWS], const real (&response)[JOINT_ROWS]) {
  const auto write3 = [lane](real(*field)[PACK], Vec3<real> v) {
    field[0][lane] = v.x;
    field[1][lane] = v.y;
    field[2][lane] = v.z;
  };
  for (u32 i = 0; i < 3; ++i) write3(block.axes + 3 * i, current.axes[i]);
  write3(block.arm_a, current.arm_a);
  write3(block.arm_b, current.arm_b);
  write3(block.free_axis, current.free_axis);
  for (u32 i = 0; i < JOINT_LOWER; ++i) block.lower[i][lane] = factor.lower[i];
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    block.inverse_pivot[i][lane] = factor.inverse_pivot[i];
    block.bias[i][lane] = bias[i];
    block.velocity_product[i][lane] = velocity_product[i];
    block.coupling[i][lane] = coupling[i];
    block.response[i][lane] = response[i];
  }
  block.velocity_product[JOINT_ROWS][lane] = velocity_product[JOINT_ROWS];
}

template <class real>
void clear_joint(JointBlock<real>& block, u32 lane) {
  const real none[JOINT_ROWS] = {}, no_velocity_product[JOINT_ROWS + 1] = {};
  write_joint(block, lane, {}, {}, none, no_velocity_product, none, none);
  for (real* field : {block.softness, block.spring, block.free_mobility, block.coupled_mobility, block.motor_speed,
                      block.motor_impulse, block.slowest, block.fastest, block.bound_softness, block.spring_compliance,
                      block.lead, block.impedance_compliance, block.impedance_speed})
    field[lane] = 0;
}

/// The pose after `time` with these velocities.
template <class real>
void move_on(const Velocity<real>& velocity, real time, Vec3<real>& x, Quat<real>& q) {
  x = add3(x, scale3(time, vec3(velocity.v)));
  q = integrate_orientation(q, vec3(velocity.w), time);
}

/// The axes and arms of `later`, what is off and the free coordinate of `now`.
template <class real>
CurrentJoint<real> with_error_of(const CurrentJoint<real>& current, CurrentJoint<real> later) {
  for (u32 i = 0; i < JOINT_ROWS; ++i) later.error[i] = current.error[i];
  later.coordinate = current.coordinate;
  return later;
}

/// The square of how far a body reaches from its centre of mass: to the anchor, or its least radius of gyration, the
/// root of 3 / (m tr I^-1), m^2; unbounded of one that cannot move.
template <class real>
real joint_body_size(const real* anchor, const Motion<real>& body) {
  if (!(body.inverse_mass > 0)) return real(JOINT_UNBOUNDED);
  const real trace = body.inertia_xx + body.inertia_yy + body.inertia_zz;
  const real arm = dot3(vec3(anchor), vec3(anchor));
  const real gyration = trace > 0 ? real(3) * body.inverse_mass / trace : real(0);
  return arm > gyration ? arm : gyration;
}

/// How far the free coordinate is beyond its limits, m or rad.
template <class real>
real joint_beyond(const Joint<real>& joint, const CurrentJoint<real>& current) {
  if (joint.limited == 0 || joint.spring_compliance > 0) return 0;
  const real beyond = std::max(joint.low - current.coordinate, current.coordinate - joint.high);
  return beyond > 0 ? beyond : real(0);
}

/// The square of how far apart its anchors are in what it locks, or beyond its limits, m^2.
template <class real>
real squared_separation(const JointInfo& info, const Joint<real>& joint, const CurrentJoint<real>& current) {
  real sum = 0;
  for (u32 i = 0; i < 3; ++i) {
    if ((info.locked >> i & 1) != 0) sum = sum + current.error[i] * current.error[i];
  }
  const real beyond = info.free == FREE_ANGLE ? real(0) : joint_beyond(joint, current);
  return sum + beyond * beyond;
}

/// What is off at a joint that is not meant to be soft, and the energy of its spring, at the start of the sub-step.
template <class real>
void measure_joint(std::vector<u32>& counters, const StepParams<real>& params, const JointInfo& info,
                   const Joint<real>& joint, const CurrentJoint<real>& current, const Motion<real>& a,
                   const Motion<real>& b) {
  const real separation = squared_separation(info, joint, current);
  const real size = std::min(joint_body_size(joint.anchor_a, a), joint_body_size(joint.anchor_b, b));
  const real beyond = info.free == FREE_ANGLE ? joint_beyond(joint, current) : real(0);
  real angle = beyond * beyond;
  for (u32 i = 3; i < JOINT_ROWS; ++i) {
    if ((info.locked >> i & 1) != 0) angle = angle + current.error[i] * current.error[i];
  }
  raise_maximum(counters, COUNTER_MAX_JOINT_SEPARATION, std::sqrt(separation));
  raise_maximum(counters, COUNTER_MAX_JOINT_SEPARATION_RATIO, std::sqrt(size > 0 ? separation / size : real(0)));
  raise_maximum(counters, COUNTER_MAX_JOINT_ANGLE, std::sqrt(angle));
  const auto add_spring = [&](real rate, real compliance, real rest) {
    if (!(compliance > 0)) return;
    const real stretch = current.coordinate - rest;
    const real stiffness = rate / (compliance * params.dt);
    add_energy(counters, COUNTER_ENERGY,
               energy_units(real(0.5) * stiffness * (stretch * stretch), params.units_per_joule));
  };
  // one of bounded force keeps no energy
  if (!(joint.motor_force < 0)) add_spring(joint.rate, joint.spring_compliance, joint.low);
  add_spring(joint.side_rate, joint.side_compliance, joint.side_rest);
}

/// The velocity that the free row had there.
template <class real>
real free_velocity_before(const Buffers<real>& buffers, const StepParams<real>& params, const JointInfo& info,
                          const CurrentJoint<real>& current) {
  const Velocity<real> a = velocity_before(buffers, params, info.body_a),
                       b = velocity_before(buffers, params, info.body_b);
  const Vec3<real> w_a = vec3(a.w), w_b = vec3(b.w);
  const Vec3<real> u = sub3(add3(vec3(b.v), cross3(w_b, current.arm_b)), add3(vec3(a.v), cross3(w_a, current.arm_a)));
  return dot3(current.free_axis, info.free == FREE_ANGLE ? sub3(w_b, w_a) : u);
}

/// Adds to the velocity products of locked rows what they moved with before, half of each: together as large.
template <class real>
void halve_with_velocities_before(const Buffers<real>& buffers, const StepParams<real>& params, const JointInfo& info,
                                  const CurrentJoint<real>& current, real (&velocity_product)[JOINT_ROWS + 1]) {
  const Velocity<real> a = velocity_before(buffers, params, info.body_a),
                       b = velocity_before(buffers, params, info.body_b);
  const Vec3<real> w_a = vec3(a.w), w_b = vec3(b.w), w = sub3(w_b, w_a);
  const Vec3<real> u = sub3(add3(vec3(b.v), cross3(w_b, current.arm_b)), add3(vec3(a.v), cross3(w_a, current.arm_a)));
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    if ((info.locked >> i & 1) == 0) continue;
    real before = dot3(current.axes[i % 3], i < 3 ? u : w);
    if (i == 2) before = before - current.lead * dot3(current.axes[2], w);
    velocity_product[i] = real(0.5) * (velocity_product[i] + before);
  }
}

/// The energy of motion that armature has, at the start of the sub-step.
template <class real>
void measure_armature(Buffers<real>& buffers, const StepParams<real>& params, const JointInfo& info,
                      const Joint<real>& joint, const CurrentJoint<real>& current) {
  if (!(joint.armature > 0)) return;
  const real u = free_velocity_before(buffers, params, info, current);
  const std::int64_t units = energy_units(real(0.5) * joint.armature * (u * u), params.units_per_joule);
  add_energy(buffers.counters, COUNTER_KINETIC, units);
  add_energy(buffers.counters, COUNTER_ENERGY, units);
}

template <class real>
void prepare_joint(Buffers<real>& buffers, const StepParams<real>& params, u32 index, u32 lane,
                   JointBlock<real>& block) {
  const JointInfo& info = buffers.joint_infos[index];
  const Joint<real>& joint = buffers.joints[index];
  Vec3<real> x_a, x_b;
  Quat<real> q_a, q_b;
  joint_pose(buffers, params, info.body_a, x_a, q_a);
  joint_pose(buffers, params, info.body_b, x_b, q_b);
  const Motion<real>&a = buffers.motions[info.body_a], &b = buffers.motions[info.body_b];
  const Velocity<real> going_a = foreseen_velocity(buffers, params, info.body_a),
                       going_b = foreseen_velocity(buffers, params, info.body_b);
  const Vec3<real> w_a = vec3(going_a.w), w_b = vec3(going_b.w);
  const real angle = params.dt * params.dt * (dot3(w_a, w_a) + dot3(w_b, w_b));
  const real foreseen = params.dt / (real(1) + angle);
  const JointSizes<real> sizes = joint_sizes(buffers, index);
  CurrentJoint<real> current = current_joint(joint, info, sizes, x_a, q_a, x_b, q_b);
  count_revolutions(buffers, params, index, current);
  if (counts_revolutions(buffers, info)) buffers.joint_angles[index] = current.coordinate;
  if (params.substep == 0 && joint.spring == 0) measure_joint(buffers.counters, params, info, joint, current, a, b);
  if (params.substep == 0) measure_armature(buffers, params, info, joint, current);
  if (params.theta != real(1)) {
    const real lead_time = (real(1) - params.theta) * foreseen;
    move_on(going_a, lead_time, x_a, q_a);
    move_on(going_b, lead_time, x_b, q_b);
    current = with_error_of(current, current_joint(joint, info, sizes, x_a, q_a, x_b, q_b));
  }
  const JointMobility<real> m = joint_mobility(current, info.free, a, b);
  const JointFactor<real> factor = factorise(m.k, info.locked);

  const bool is_free = info.free != FREE_NOTHING;
  real velocity_product[JOINT_ROWS + 1];
  row_rates(current, info, going_a, going_b, velocity_product);
  const real ahead = real(0.5) * foreseen;
  real bias[JOINT_ROWS], coupling[JOINT_ROWS], response[JOINT_ROWS];
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    const bool locked = (info.locked >> i & 1) != 0;
    bias[i] = locked ? joint.correction * current.error[i] / params.dt : real(0);
    velocity_product[i] = locked ? ahead * velocity_product[i] : real(0);
    coupling[i] = locked && is_free ? m.coupling[i] : real(0);
    response[i] = coupling[i];
  }
  if (params.theta == real(0.5)) halve_with_velocities_before(buffers, params, info, current, velocity_product);
  // the rate of an angle about an axis that both bodies hold changes as their velocities do
  const bool rotates = info.free != FREE_ANGLE || LOCKS_CROSS(info.locked);
  const real free_product = rotates ? foreseen * velocity_product[JOINT_ROWS] : real(0);
  const bool equal = joint.limited != 0 && joint.low == joint.high && !(joint.spring_compliance > 0);
  velocity_product[JOINT_ROWS] = equal ? ahead * velocity_product[JOINT_ROWS] : real(0);
  solve_factor(factor, response);
  real coupled_mobility = 0;
  for (u32 i = 0; i < JOINT_ROWS; ++i) coupled_mobility = coupled_mobility + coupling[i] * response[i];

  write_joint(block, lane, current, factor, bias, velocity_product, coupling, response);
  block.softness[lane] = joint.softness;
  block.spring[lane] = joint.spring;
  block.free_mobility[lane] = is_free ? m.free_mobility : real(0);
  block.coupled_mobility[lane] = coupled_mobility;
  const bool bounds_spring = joint.motor_force < 0;
  block.motor_speed[lane] = bounds_spring ? joint.motor_speed * params.dt : joint.motor_speed;
  block.motor_impulse[lane] = joint.motor_force * params.dt;
  const real before = is_free ? free_velocity_before(buffers, params, info, current) : real(0);
  real mobility = block.free_mobility[lane] - coupled_mobility;
  if (joint.armature > 0) mobility = mobility / (real(1) + joint.armature * mobility);
  const SpringLaw<real> spring =
      spring_law(joint.rate, joint.spring_compliance, params, current.coordinate - joint.low, mobility, before);
  const SpringLaw<real> side = spring_law(joint.side_rate, joint.side_compliance, params,
                                          current.coordinate - joint.side_rest, mobility, before);
  const SpringLaw<real> impedance = impedance_law(joint.armature, side, before - free_product);
  const FreeLaw<real> law = free_law(joint, current.coordinate, spring, counts_revolutions(buffers, info),
                                     velocity_product[JOINT_ROWS], params.dt);
  block.slowest[lane] = law.slowest;
  block.fastest[lane] = law.fastest;
  block.bound_softness[lane] = law.bound_softness;
  block.spring_compliance[lane] = spring.compliance;
  block.lead[lane] = current.lead;
  block.impedance_compliance[lane] = impedance.compliance;
  block.impedance_speed[lane] = impedance.compliance > 0 ? -impedance.bias : real(0);
}

template <class real>
void prepare_joints(Buffers<real>& buffers, const StepParams<real>& params) {
  if (step_aborted(buffers.counters)) return;
  for (u32 block = 0; block < params.joint_blocks; ++block) {
    for (u32 lane = 0; lane < PACK; ++lane) {
      const u32 joint = buffers.joint_lanes[block].joint[lane];
      if (joint != NONE && !joint_sleeps(buffers, buffers.joint_infos[joint]))
        prepare_joint(buffers, params, joint, lane, buffers.joint_blocks[block]);
      else if (params.substep == 0)  // nothing writes it until the next step
        clear_joint(buffers.joint_blocks[block], lane);
    }
  }
}

}  // namespace lockstep::reference
