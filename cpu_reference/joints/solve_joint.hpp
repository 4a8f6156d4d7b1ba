// Solves one joint: what the solver's sweeps and the warm start share. kernels/joints/solve_joint.h is the twin,
// LANES joints at a time.
//
// With the impulses of all others held, the joint's own problem (cpu_reference/prepare_joints.hpp) is solved exactly:
//   the locked rows alone would change their impulses by   d0 = -g K^-1 (u + bias + J'v) - s g r,   g = 1 / (1 + s)
//   the free row then moves at                             q + e r_f,   e = free_mobility - g coupled_mobility
//   its impulse brings it to the motor's speed, as far as the motor reaches, and into its bounds
//   beside a spring of compliance y a push moves it by     e y / (e + y) only
//   and none leaves it at                                  s + (q - s) y / (e + y), by an impulse (s - q) / (e + y),
//   where s is the speed at which the spring would not push
//   the locked rows answer                                 d = d0 - g response (change of r_f)
// Beside an impedance of compliance z, which pushes r_i = (p - u) / z, the free row is less mobile, e' = e z / (e + z),
// and moves at q' = p + (q - p) z / (e + z) without r_f: all that is said of r_f holds with these, and then
//   r_i = (p - q - e r_f) / (e + z)
// The relaxing sweep asks joints that are not meant to be springs to be hard, without correction; the springs of free
// coordinates push in it as before.
#pragma once

#include "cpu_reference/joints/factor.hpp"
#include "cpu_reference/purpose.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/solve_contact.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
Vec3<real> joint_vector(const real (*field)[PACK], u32 lane) {
  return {field[0][lane], field[1][lane], field[2][lane]};
}

/// What impulses of the rows push with at b's anchor, N s, and the moment that they have there, N m s. That of a
/// screw's thread turns what it pushes.
template <class real>
struct JointEffort {
  Vec3<real> impulse, moment;
};

template <class real>
JointEffort<real> joint_effort(const JointBlock<real>& block, u32 free, u32 lane, const real (&r)[JOINT_ROWS],
                               real r_free) {
  const Vec3<real> x = joint_vector(block.axes, lane), y = joint_vector(block.axes + 3, lane),
                   z = joint_vector(block.axes + 6, lane), along = joint_vector(block.free_axis, lane);
  const Vec3<real> impulse = add3(add3(scale3(r[0], x), scale3(r[1], y)), scale3(r[2], z));
  const real about_z = block.lead[lane] != 0 ? -(block.lead[lane] * r[2]) : r[5];
  const Vec3<real> moment = add3(add3(scale3(r[3], x), scale3(r[4], y)), scale3(about_z, z));
  const bool angular = free == FREE_ANGLE;
  return {add3(impulse, scale3(angular ? real(0) : r_free, along)),
          add3(moment, scale3(angular ? r_free : real(0), along))};
}

/// Impulses of the rows on b, their opposite on a. Bodies that cannot move are never written (contract rule 8).
template <class real>
void push_joint(const JointBlock<real>& block, u32 free, u32 lane, const real (&r)[JOINT_ROWS], real r_free,
                Motion<real>& a, Motion<real>& b) {
  const auto [impulse, moment] = joint_effort(block, free, lane, r, r_free);
  if (a.inverse_mass > 0) {
    const Vec3<real> arm = joint_vector(block.arm_a, lane);
    store3(a.v, sub3(vec3(a.v), scale3(a.inverse_mass, impulse)));
    store3(a.w, sub3(vec3(a.w), apply_inverse_inertia(a, add3(cross3(arm, impulse), moment))));
  }
  if (b.inverse_mass > 0) {
    const Vec3<real> arm = joint_vector(block.arm_b, lane);
    store3(b.v, add3(vec3(b.v), scale3(b.inverse_mass, impulse)));
    store3(b.w, add3(vec3(b.w), apply_inverse_inertia(b, add3(cross3(arm, impulse), moment))));
  }
}

/// The velocity of the free row within its bounds: u is what it has without them.
template <class real>
real bounded_speed(real u, real slowest, real fastest, real bound_softness) {
  if (u < slowest) return u + (slowest - u) / (real(1) + bound_softness);
  if (u > fastest) return u + (fastest - u) / (real(1) + bound_softness);
  return u;
}

/// What the locked rows alone would change their impulses by, were they hard: d = -K^-1 (u + bias + J'v), from the
/// velocity u and the angular velocity w of b against a. `share`: how much of the bias counts.
template <class real>
void solve_locked_rows(const JointBlock<real>& block, u32 lane, real share, Vec3<real> u, Vec3<real> w,
                       real (&d)[JOINT_ROWS]) {
  for (u32 i = 0; i < 3; ++i) {
    const Vec3<real> axis = joint_vector(block.axes + 3 * i, lane);
    d[i] = -(dot3(axis, u) + share * block.bias[i][lane] + block.velocity_product[i][lane]);
    d[i + 3] = -(dot3(axis, w) + share * block.bias[i + 3][lane] + block.velocity_product[i + 3][lane]);
  }
  const real lead = block.lead[lane];
  if (lead != 0) d[2] = d[2] + lead * dot3(joint_vector(block.axes + 6, lane), w);
  JointFactor<real> factor;
  for (u32 i = 0; i < JOINT_LOWER; ++i) factor.lower[i] = block.lower[i][lane];
  for (u32 i = 0; i < JOINT_ROWS; ++i) factor.inverse_pivot[i] = block.inverse_pivot[i][lane];
  solve_factor(factor, d);
}

/// The impulse that the free row gets, from its bounds and the mobility e > 0 with which it moves at q without an
/// impulse: the motor brings it to its speed as far as it reaches, the spring or the bounds bring it back. What a
/// spring gives follows from what it is stretched by: it changes the speed by little, of which float would round a part
/// away.
template <class real>
real free_impulse(const JointBlock<real>& block, u32 lane, real e, real q, real slowest, real fastest,
                  real bound_softness) {
  const real spring_compliance = block.spring_compliance[lane], motor_impulse = block.motor_impulse[lane];
  const bool sprung = spring_compliance > 0;
  const real left = sprung ? spring_compliance / (e + spring_compliance) : real(1);  // of a push, beside the spring
  const real idle = sprung ? slowest + left * (q - slowest) : q;
  const real motor_change = left * (e * motor_impulse);
  const real wanted = block.motor_speed[lane];
  const bool brakes = wanted<idle - motor_change, pushes = wanted> idle + motor_change;
  const real driven = brakes ? idle - motor_change : (pushes ? idle + motor_change : wanted);
  if (!sprung) return (bounded_speed(driven, slowest, fastest, bound_softness) - q) / e;
  const real alone = (slowest - q) / (e + spring_compliance);
  if (motor_impulse < 0) {  // a spring of bounded force
    const real least = wanted + motor_impulse, most = wanted - motor_impulse;
    return alone < least ? least : (alone > most ? most : alone);
  }
  if (!(motor_impulse > 0)) return alone;
  if (brakes) return alone - left * motor_impulse;
  return pushes ? alone + left * motor_impulse : (wanted - q) / e;
}

/// How easily the free row moves, and at what velocity without an impulse of its own.
template <class real>
struct FreeRow {
  real e, q;
};

/// The same beside the joint's impedance, which answers.
template <class real>
FreeRow<real> beside_impedance(const JointBlock<real>& block, u32 lane, FreeRow<real> row) {
  const real compliance = block.impedance_compliance[lane], speed = block.impedance_speed[lane];
  if (!(compliance > 0)) return row;
  const real left = compliance / (row.e + compliance);
  return {left * row.e, speed + left * (row.q - speed)};
}

/// The impulse that an impedance has beside one of `r_free`, where the row moved at q without either.
template <class real>
real impedance_impulse(const JointBlock<real>& block, u32 lane, FreeRow<real> row, real r_free) {
  return (block.impedance_speed[lane] - row.q - row.e * r_free) / (row.e + block.impedance_compliance[lane]);
}

template <class real>
bool has_impedance(const JointBlock<real>& block, u32 lane) {
  return block.impedance_compliance[lane] > 0;
}

/// All that the free row pushes with.
template <class real>
real whole_free_impulse(const JointBlock<real>& block, u32 lane, const JointImpulseBlock<real>& impulses) {
  const real free = impulses.free[lane];
  return has_impedance(block, lane) ? free + impulses.impedance[lane] : free;
}

/// The square of by how much a solve changed the velocity of b against a, at b's anchor: u and w are what it was. A
/// rotation counts at a radius of gyration of the two bodies.
template <class real>
real joint_change(Vec3<real> u, Vec3<real> w, Vec3<real> arm_a, Vec3<real> arm_b, const Motion<real>& a,
                  const Motion<real>& b) {
  const Vec3<real> du = sub3(velocity_at(arm_b, arm_a, b, a), u), dw = sub3(sub3(vec3(b.w), vec3(a.w)), w);
  const real trace = a.inertia_xx + a.inertia_yy + a.inertia_zz + b.inertia_xx + b.inertia_yy + b.inertia_zz;
  return dot3(du, du) + real(3) * (a.inverse_mass + b.inverse_mass) / trace * dot3(dw, dw);
}

/// Returns the square of by how much it changed the relative velocity.
template <class real>
real solve_joint(Purpose purpose, const JointBlock<real>& block, u32 free, u32 lane, JointImpulseBlock<real>& impulses,
                 Motion<real>& a, Motion<real>& b) {
  const real spring = block.spring[lane];
  const bool relaxed = purpose == Purpose::relax;
  const real share = relaxed ? spring : real(1);  // of bias and softness
  const real softness = share * block.softness[lane];
  const real g = real(1) / (real(1) + softness);
  real slowest = block.slowest[lane], fastest = block.fastest[lane];
  if (relaxed && !(spring > 0) && !(block.spring_compliance[lane] > 0)) {  // a bound that excludes rest is a correction
    const bool equal = slowest == fastest;
    const real still = -block.velocity_product[JOINT_ROWS][lane];
    slowest = equal ? still : (slowest > 0 ? real(0) : slowest);
    fastest = equal ? still : (fastest < 0 ? real(0) : fastest);
  }

  const Vec3<real> arm_a = joint_vector(block.arm_a, lane), arm_b = joint_vector(block.arm_b, lane);
  const Vec3<real> u = velocity_at(arm_b, arm_a, b, a), w = sub3(vec3(b.w), vec3(a.w));
  real d[JOINT_ROWS];
  solve_locked_rows(block, lane, share, u, w, d);
  real before = dot3(joint_vector(block.free_axis, lane), free == FREE_ANGLE ? w : u);
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    d[i] = g * (d[i] - softness * impulses.locked[i][lane]);
    before = before + block.coupling[i][lane] * d[i];
  }

  const real old = impulses.free[lane], old_whole = whole_free_impulse(block, lane, impulses);
  const real e = block.free_mobility[lane] - g * block.coupled_mobility[lane];
  const FreeRow<real> alone = {e, before - e * old_whole};  // without any impulse of the free row
  const FreeRow<real> row = beside_impedance(block, lane, alone);
  // a joint that sleeps has no mobility, and keeps its impulse
  const real r_free =
      e > 0 ? free_impulse(block, lane, row.e, row.q, slowest, fastest, share * block.bound_softness[lane])
            : (block.free_mobility[lane] > 0 ? real(0) : old);
  if (e > 0 && has_impedance(block, lane)) impulses.impedance[lane] = impedance_impulse(block, lane, alone, r_free);
  impulses.free[lane] = r_free;
  const real change = whole_free_impulse(block, lane, impulses) - old_whole;

  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    d[i] = d[i] - g * block.response[i][lane] * change;
    impulses.locked[i][lane] = impulses.locked[i][lane] + d[i];
  }
  push_joint(block, free, lane, d, change, a, b);
  return joint_change(u, w, arm_a, arm_b, a, b);
}

/// Calls function(lanes, block, lane) for every joint, phase after phase: as blocks are laid out in that order, simply
/// one after another.
template <class real, class Function>
void for_each_joint_slot(const Buffers<real>& buffers, Function&& function) {
  for (u32 block = 0; block < buffers.joint_lanes.size(); ++block) {
    const JointLanes& lanes = buffers.joint_lanes[block];
    for (u32 lane = 0; lane < PACK; ++lane) {
      if (lanes.joint[lane] != NONE) function(lanes, block, lane);
    }
  }
}

/// One sweep over all joints but those that their articulation solves alone. Returns the square of the largest change
/// of a relative velocity.
template <class real>
real sweep_joints(Purpose purpose, Buffers<real>& buffers) {
  real change = 0;
  for_each_joint_slot(buffers, [&](const JointLanes& lanes, u32 block, u32 lane) {
    if (buffers.joint_infos[lanes.joint[lane]].direct != 0) return;
    Motion<real>&a = buffers.motions[lanes.body_a[lane]], &b = buffers.motions[lanes.body_b[lane]];
    change = larger(
        solve_joint(purpose, buffers.joint_blocks[block], lanes.free[lane], lane, buffers.joint_impulses[block], a, b),
        change);
  });
  return change;
}

template <class real>
void start_joints(Buffers<real>& buffers) {
  for_each_joint_slot(buffers, [&](const JointLanes& lanes, u32 block, u32 lane) {
    const JointImpulseBlock<real>& impulses = buffers.joint_impulses[block];
    real r[JOINT_ROWS];
    for (u32 i = 0; i < JOINT_ROWS; ++i) r[i] = impulses.locked[i][lane];
    push_joint(buffers.joint_blocks[block], lanes.free[lane], lane, r,
               whole_free_impulse(buffers.joint_blocks[block], lane, impulses), buffers.motions[lanes.body_a[lane]],
               buffers.motions[lanes.body_b[lane]]);
  });
}

}  // namespace lockstep::reference
