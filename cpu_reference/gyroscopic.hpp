// Euler's equations of a rotating body (survey eq. 8), in its principal frame where the inertia I is diagonal:
//
//   I w' + w x I w = tau        or, divided by I,        w' + r (w_y w_z, w_z w_x, w_x w_y) = I^-1 tau
//
// with the ratios r = ((I_z - I_y) / I_x, (I_x - I_z) / I_y, (I_y - I_x) / I_z), which lie within [-1, 1] for every
// real body. kernels/gyroscopic.h says the same in OpenCL C.
#pragma once

#include "cpu_reference/rigid_body.hpp"

namespace lockstep::reference {

/// A step over which a body rotates by up to one radian is solved at once, another in parts, at most this many. Beyond,
/// nothing is left to be resolved: the moment is left out.
constexpr u32 max_gyroscopic_substeps = 64;
/// Newton's method converges to rounding in 5 iterations at the midpoint and in 8 at worst (measured in double over
/// 200,000 random bodies).
constexpr u32 gyroscopic_iterations = 8;
/// Each iteration squares the error: after a change by less than this share, squared, only rounding is left.
template <class real>
constexpr real gyroscopic_tolerance = sizeof(real) == 8 ? real(1e-17) : real(1e-8);
/// Impulses that change w by less than this share, squared, of what the gyroscopic moment does leave a body free: that
/// much is rounding, of sums that give back what they took.
template <class real>
constexpr real free_share = real(1e-6);

template <class real>
Vec3<real> gyroscopic_ratios(const Mass<real>& mass) {
  return {(mass.inertia[2] - mass.inertia[1]) * mass.inverse_inertia[0],
          (mass.inertia[0] - mass.inertia[2]) * mass.inverse_inertia[1],
          (mass.inertia[1] - mass.inertia[0]) * mass.inverse_inertia[2]};
}
template <class real>
Vec3<real> gyroscopic_term(Vec3<real> ratios, Vec3<real> w) {
  return {ratios.x * (w.y * w.z), ratios.y * (w.z * w.x), ratios.z * (w.x * w.y)};
}

/// Cramer's rule for three equations given row by row.
template <class real>
Vec3<real> solve3(Vec3<real> row_x, Vec3<real> row_y, Vec3<real> row_z, Vec3<real> right) {
  const Vec3<real> yz = cross3(row_y, row_z);
  const Vec3<real> zx = cross3(row_z, row_x);
  const Vec3<real> xy = cross3(row_x, row_y);
  const Vec3<real> sum = add3(add3(scale3(right.x, yz), scale3(right.y, zx)), scale3(right.z, xy));
  return scale3(real(1) / dot3(row_x, yz), sum);
}

/// Solves  x - w - delta_w + dt r y y = 0  with  y = (1 - theta) w + theta x  by Newton's method.
template <class real>
Vec3<real> gyroscopic_substep(Vec3<real> ratios, Vec3<real> w, Vec3<real> delta_w, real theta, real dt) {
  const Vec3<real> start = add3(w, delta_w);
  const Vec3<real> a = scale3(dt * theta, ratios);
  Vec3<real> x = start;
  for (u32 i = 0; i < gyroscopic_iterations; ++i) {
    const Vec3<real> y = mean3(theta, w, x);
    const Vec3<real> defect = add3(sub3(x, start), scale3(dt, gyroscopic_term(ratios, y)));
    const Vec3<real> row_x = {real(1), a.x * y.z, a.x * y.y};
    const Vec3<real> row_y = {a.y * y.z, real(1), a.y * y.x};
    const Vec3<real> row_z = {a.z * y.y, a.z * y.x, real(1)};
    const Vec3<real> change = solve3(row_x, row_y, row_z, defect);
    x = sub3(x, change);
    if (dot3(change, change) <= gyroscopic_tolerance<real> * dot3(x, x)) break;
  }
  return x;
}

/// The angular momentum in parts of the first moment of inertia, body frame.
template <class real>
Vec3<real> relative_momentum(const Mass<real>& mass, Vec3<real> w) {
  const real unit = mass.inverse_inertia[0];
  return {w.x, (mass.inertia[1] * unit) * w.y, (mass.inertia[2] * unit) * w.z};
}

/// By how much less the Cayley map of 2 z rotates than by 2 |z|, as a rotation about the momentum: half of it has the
/// tangent (t - |z|) / (1 + t |z|), t = tan |z|.
template <class real>
Quat<real> missing_rotation(Vec3<real> momentum, Vec3<real> z) {
  const real squared = dot3(momentum, momentum), y = dot3(z, z);
  if (!(squared > real(0)) || !(y < real(1))) return {real(0), real(0), real(0), real(1)};
  const TangentRatio<real> ratio = tangent_ratio(y);
  const Vec3<real> along = scale3(dot3(momentum, z) / squared * (ratio.numerator - ratio.denominator), momentum);
  return {along.x, along.y, along.z, ratio.denominator + y * ratio.numerator};
}

/// How a body rotates over a step in which no impulse acts on it.
template <class real>
struct FreeStep {
  Vec3<real> w;         // after the step, in the frame that has rotated by then
  Quat<real> rotation;  // in the frame before the step, not of unit length
};

/// Euler's equation over dt, body frame:
///
///   I (w' - w) + dt w_th x I w_th = dt tau,   w_th = (1 - theta) w + theta w'
///
/// where delta_w = dt I^-1 tau. theta = 0 is explicit, one evaluation, and gains energy; theta = 1 never gains any;
/// theta = 1/2 conserves the energy of a free body and, rotated by the Cayley map of dt w_th, its angular momentum L
/// (Simo and Wong 1991). That map rotates by 2 atan(|w_th| dt / 2), which is too little; what is missing along L
/// follows as a rotation about L, which changes nothing of it.
///
/// The rotation is by w_th and, of what a moment from outside gives, the share `position_theta`, as of all bodies.
template <class real>
FreeStep<real> gyroscopic_step(const Mass<real>& mass, Vec3<real> w, Vec3<real> delta_w, real theta,
                               real position_theta, real dt) {
  const Vec3<real> ratios = gyroscopic_ratios(mass);
  const Vec3<real> end = add3(w, delta_w);
  const real angle_squared = std::max(dot3(w, w), dot3(end, end)) * (dt * dt);
  u32 substeps = 1;
  while (substeps < max_gyroscopic_substeps && real(substeps * substeps) < angle_squared) substeps += substeps;
  const bool too_fast = real(substeps * substeps) < angle_squared;
  if (theta == real(0) || too_fast) {
    const Quat<real> rotation = rotation_by(add3(w, scale3(position_theta, delta_w)), dt);
    return {too_fast ? end : sub3(end, scale3(dt, gyroscopic_term(ratios, w))), rotation};
  }

  const real share = real(1) / real(substeps);
  const real substep_dt = share * dt;
  const Vec3<real> substep_delta_w = scale3(share, delta_w);
  Quat<real> rotation = {real(0), real(0), real(0), real(1)};
  for (u32 i = 0; i < substeps; ++i) {
    const Vec3<real> x = gyroscopic_substep(ratios, w, substep_delta_w, theta, substep_dt);
    const Vec3<real> mean_w = add3(mean3(theta, w, x), scale3(position_theta - theta, substep_delta_w));
    const Vec3<real> z = scale3(real(0.5) * substep_dt, mean_w);
    rotation = multiply4(
        rotation, multiply4(missing_rotation(relative_momentum(mass, w), z), Quat<real>{z.x, z.y, z.z, real(1)}));
    w = x;
  }
  return {w, rotation};
}

/// Whether the impulses of a sub-step act on a body as it is in its middle: by the trapezoidal rule, where its moments
/// of inertia differ.
template <class real>
bool acts_in_middle(const StepParams<real>& params, const BodyInfo& info, bool pivoted) {
  return params.theta == real(0.5) && info.kind == BODY_DYNAMIC && is_gyroscopic(params, info) && !pivoted;
}

/// Whether a body keeps its angular velocity in its own frame where closing a joint rotates it: where its moments of
/// inertia differ, as its energy is that of w there.
template <class real>
bool is_carried(const StepParams<real>& params, const BodyInfo& info) {
  return params.theta > real(0) && info.kind == BODY_DYNAMIC && is_gyroscopic(params, info);
}

/// Whether joints hold it; scenes without joints have no lists of them.
inline bool is_jointed(const std::vector<u32>& body_joint_starts, u32 i) {
  return !body_joint_starts.empty() && body_joint_starts[i] != body_joint_starts[i + 1];
}

/// There: what rotates with w_old keeps it.
template <class real>
Quat<real> orientation_in_middle(Quat<real> old_q, Vec3<real> w_old, real dt) {
  return integrate_orientation(old_q, w_old, real(0.5) * dt);
}

/// What the gyroscopic moment takes off an angular velocity over dt, body frame, of a step that ends with w_new.
template <class real>
Vec3<real> gyroscopic_loss(const Mass<real>& mass, Vec3<real> w_old, Vec3<real> w_new, real theta, real dt) {
  return scale3(dt, gyroscopic_term(gyroscopic_ratios(mass), mean3(theta, w_old, w_new)));
}

/// The angular velocity w that impulses leave, with the gyroscopic moment of it instead of that of the free rotation.
/// q: the orientation in the middle of the step, or by the semi-implicit rule at its start. Where a body rotates by
/// more than half a revolution, w.
///
/// What joints do not allow of the change the next step takes back. By the semi-implicit rule, which has the impulses
/// act on what it has left from the last one, an unbalanced wheel would gain energy so: the change then does no work on
/// them, (w - foreseen) I change = 0.
template <class real>
Vec3<real> correct_gyroscopic_moment(const StepParams<real>& params, const Mass<real>& mass,
                                     const FreeRotation<real>& free_rotation, Quat<real> q, Vec3<real> w_old,
                                     Vec3<real> w) {
  const real dt = params.dt, theta = params.gyroscopic_theta;
  const Vec3<real> before = unrotate3(q, w_old), foreseen = unrotate3(q, vec3(free_rotation.w)),
                   after = unrotate3(q, w);
  const real pi_squared = real(9.8696044010893586);
  if (std::max(dot3(before, before), dot3(after, after)) * (dt * dt) > pi_squared) return w;
  Vec3<real> change =
      sub3(gyroscopic_loss(mass, before, foreseen, theta, dt), gyroscopic_loss(mass, before, after, theta, dt));
  if (params.theta == real(1)) {
    const Vec3<real> pushed = sub3(after, foreseen), momentum = multiply3(vec3(mass.inertia), pushed);
    const real squared = dot3(momentum, pushed);
    if (squared > real(0)) change = sub3(change, scale3(dot3(momentum, change) / squared, pushed));
  }
  return add3(w, rotate3(q, change));
}

}  // namespace lockstep::reference
