// A step of a joint along the projected gradient (cpu_reference/gradient/descent.hpp): what
// cpu_reference/joints/solve_joint.hpp solves, for a joint that its impulses move sigma = D_j / (step K) times as
// easily as they do. Its rows are not projected one by one: in its metric the locked ones and the free one, with its
// motor, its limits and its spring, are one small problem, which is solved exactly.
//   the locked rows alone       d0 = -g (K^-1 (u + bias + J'v) + s y),   g = 1 / (sigma + s)
//   the free row then moves at  q + e r_f,   e = sigma (free_mobility - g sigma coupled_mobility)
//   the locked rows answer      d = d0 - g sigma response (change of r_f)
// kernels/gradient/gradient_joints.h is the twin, LANES joints at a time.
#pragma once

#include "cpu_reference/gradient/gradient_pairs.hpp"
#include "cpu_reference/joints/solve_joint.hpp"

namespace lockstep::reference {

template <class real>
void take_joint_step(real beta, const JointImpulseBlock<real>& next, u32 lane, JointImpulseBlock<real>& r,
                     JointImpulseBlock<real>& y) {
  for (u32 i = 0; i < JOINT_ROWS; ++i) take_step(beta, next.locked[i][lane], r.locked[i][lane], y.locked[i][lane]);
  take_step(beta, next.free[lane], r.free[lane], y.free[lane]);
  take_step(beta, next.impedance[lane], r.impedance[lane], y.impedance[lane]);
}

/// What impulses of the rows do to the bodies, b the opposite of a but for its arm.
template <class real>
struct JointPush {
  Vec3<real> impulse, moment_a, moment_b;  // on b, about its centre of mass; of a before the sign
};

template <class real>
JointPush<real> joint_push(const JointBlock<real>& block, u32 free, u32 lane, const real (&r)[JOINT_ROWS],
                           real r_free) {
  const JointEffort<real> effort = joint_effort(block, free, lane, r, r_free);
  const Vec3<real> arm_a = joint_vector(block.arm_a, lane), arm_b = joint_vector(block.arm_b, lane);
  return {effort.impulse, add3(cross3(arm_a, effort.impulse), effort.moment),
          add3(cross3(arm_b, effort.impulse), effort.moment)};
}

/// x K y of what two sets of impulses push: by the whole bodies, J.
template <class real>
real joint_product(const JointPush<real>& x, const JointPush<real>& y, const Motion<real>& a, const Motion<real>& b) {
  return (a.inverse_mass + b.inverse_mass) * dot3(x.impulse, y.impulse) +
         dot3(x.moment_a, apply_inverse_inertia(a, y.moment_a)) +
         dot3(x.moment_b, apply_inverse_inertia(b, y.moment_b));
}

/// As a body at rest would move.
template <class real>
Motion<real> moved_by(const Motion<real>& body, Vec3<real> impulse, Vec3<real> moment) {
  Motion<real> moved = body;
  store3(moved.v, scale3(body.inverse_mass, impulse));
  store3(moved.w, apply_inverse_inertia(body, moment));
  return moved;
}

/// The step of a joint from y to next. `sides` is D in parts of K.
template <class real>
PairStep<real> step_joint(const JointBlock<real>& block, u32 free, u32 lane, real sides, real step,
                          const Motion<real>& a, const Motion<real>& b, const JointImpulseBlock<real>& r,
                          const JointImpulseBlock<real>& y, JointImpulseBlock<real>& next) {
  const real sigma = sides / step, softness = block.softness[lane];
  const real g = real(1) / (sigma + softness);
  const Vec3<real> arm_a = joint_vector(block.arm_a, lane), arm_b = joint_vector(block.arm_b, lane);
  const Vec3<real> u = velocity_at(arm_b, arm_a, b, a), w = sub3(vec3(b.w), vec3(a.w));
  real d[JOINT_ROWS];
  solve_locked_rows(block, lane, real(1), u, w, d);
  real before = dot3(joint_vector(block.free_axis, lane), free == FREE_ANGLE ? w : u);
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    d[i] = g * (d[i] - softness * y.locked[i][lane]);
    before = before + sigma * (block.coupling[i][lane] * d[i]);
  }

  const real old = whole_free_impulse(block, lane, y), free_mobility = block.free_mobility[lane],
             coupled_mobility = block.coupled_mobility[lane];
  const real e = sigma * (free_mobility - g * sigma * coupled_mobility);
  const FreeRow<real> alone = {e, before - e * old}, row = beside_impedance(block, lane, alone);
  const real own = free_mobility - coupled_mobility / (real(1) + softness);
  const real unscaled = beside_impedance(block, lane, {own, real(0)}).e;
  const real bound_softness = block.bound_softness[lane] * (unscaled / row.e);  // in parts of e
  const real r_free =
      e > 0 ? free_impulse(block, lane, row.e, row.q, block.slowest[lane], block.fastest[lane], bound_softness)
            : real(0);
  next.free[lane] = r_free;
  next.impedance[lane] =
      e > 0 && has_impedance(block, lane) ? impedance_impulse(block, lane, alone, r_free) : y.impedance[lane];
  const real whole = whole_free_impulse(block, lane, next), change = whole - old;

  real ahead[JOINT_ROWS];
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    d[i] = d[i] - g * sigma * block.response[i][lane] * change;
    next.locked[i][lane] = y.locked[i][lane] + d[i];
    ahead[i] = next.locked[i][lane] - r.locked[i][lane];
  }
  const JointPush<real> push = joint_push(block, free, lane, d, change);
  const JointPush<real> along = joint_push(block, free, lane, ahead, whole - whole_free_impulse(block, lane, r));

  PairStep<real> out;
  out.a = {sub3(Vec3<real>{0, 0, 0}, push.impulse), sub3(Vec3<real>{0, 0, 0}, push.moment_a), 0, 0};
  out.b = {push.impulse, push.moment_b, 0, 0};
  out.length = sides * joint_product(push, push, a, b);
  out.uphill = -(sides * joint_product(push, along, a, b));
  const Vec3<real> still = {0, 0, 0};
  out.change = sigma * sigma *
               joint_change(still, still, arm_a, arm_b, moved_by(a, out.a.impulse, out.a.moment),
                            moved_by(b, push.impulse, push.moment_b));
  return out;
}

}  // namespace lockstep::reference
