// Bodies that nothing touches, velocities and poses in one stage of fourth order.
//
//   x' = x + dt v + dt^2/2 g,   v' = v + dt g                    exact for a constant gravity
//   R_dot = R [w],              w_dot = I^-1 (tau - w x I w)     survey eqs. 1 and 8, w and tau in the body frame
//
// The rotation takes one step of the Runge-Kutta-Munthe-Kaas method that stands on the classical one (Munthe-Kaas,
// High order Runge-Kutta methods on manifolds, 1999; with two commutators as in Iserles et al., Lie-group methods,
// 2000, section 4): with R = R_0 exp([u]) the rotation vector u is what is integrated, u_dot = w + u x w / 2 + ..., so
// that a constant w is exact. A body on a pivot turns about it: I and tau = com_offset x m g are about the pivot.
#pragma once

#include "cpu_reference/gyroscopic.hpp"
#include "cpu_reference/measure.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// An orientation and the angular velocity in the body frame.
template <class real>
struct RotationState {
  Quat<real> q;
  Vec3<real> w;
};

/// What turns a body.
template <class real>
struct RotationLaw {
  Vec3<real> ratios, inverse_inertia;
  Vec3<real> weight, com_offset;  // m g in the world frame; from the pivot to the centre of mass, body frame
};

/// Rotated by a vector of the body frame.
template <class real>
Quat<real> rotate_in_body(Quat<real> q, Vec3<real> u) {
  return unit4(multiply4(q, rotation_by(u, real(1))));
}
/// By how much the angular velocity changes in dt.
template <class real>
Vec3<real> delta_w(RotationLaw<real> law, Quat<real> q, Vec3<real> w, real dt) {
  const Vec3<real> moment = cross3(law.com_offset, unrotate3(q, law.weight));
  return scale3(dt, sub3(multiply3(law.inverse_inertia, moment), gyroscopic_term(law.ratios, w)));
}
template <class real>
Vec3<real> runge_kutta_mean(Vec3<real> a, Vec3<real> b, Vec3<real> c, Vec3<real> d) {
  return scale3(real(1) / real(6), add3(add3(a, d), scale3(real(2), add3(b, c))));
}
template <class real>
RotationState<real> rotation_step(RotationLaw<real> law, RotationState<real> start, real dt) {
  const real halved = real(0.5);
  const Vec3<real> angle_1 = scale3(dt, start.w), change_1 = delta_w(law, start.q, start.w, dt);
  const Quat<real> q_2 = rotate_in_body(start.q, scale3(halved, angle_1));
  const Vec3<real> w_2 = add3(start.w, scale3(halved, change_1));
  const Vec3<real> angle_2 = scale3(dt, w_2), change_2 = delta_w(law, q_2, w_2, dt);
  const Quat<real> q_3 =
      rotate_in_body(start.q, add3(scale3(halved, angle_2), scale3(real(0.125), cross3(angle_1, angle_2))));
  const Vec3<real> w_3 = add3(start.w, scale3(halved, change_2));
  const Vec3<real> angle_3 = scale3(dt, w_3), change_3 = delta_w(law, q_3, w_3, dt);
  const Quat<real> q_4 = rotate_in_body(start.q, angle_3);
  const Vec3<real> w_4 = add3(start.w, change_3);
  const Vec3<real> angle_4 = scale3(dt, w_4), change_4 = delta_w(law, q_4, w_4, dt);
  const Vec3<real> rotation =
      add3(runge_kutta_mean(angle_1, angle_2, angle_3, angle_4), scale3(real(1) / real(12), cross3(angle_1, angle_4)));
  return {rotate_in_body(start.q, rotation), add3(start.w, runge_kutta_mean(change_1, change_2, change_3, change_4))};
}

template <class real>
void integrate_free_flight(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;

  for (u32 i = 0; i < params.bodies; ++i) {
    const BodyInfo info = b.body_infos[i];
    if (info.kind == BODY_STATIC) continue;
    const bool dynamic = info.kind == BODY_DYNAMIC;
    const bool pivoted = dynamic && is_pivoted(b.pivots, i);
    const bool gyroscopic = dynamic && is_gyroscopic(params, info);

    const Mass<real> mass = b.masses[i];
    Motion<real>& motion = b.motions[i];
    Vec3<real> v = vec3(motion.v);
    Vec3<real> w = vec3(motion.w);
    Vec4<real>& position = b.positions[i];
    Vec3<real> x = vec3_of(position);
    Vec3<real> gravity = {};
    if (dynamic) gravity = vec3_of(b.gravities[info.world]);

    if (params.substep == 0 && dynamic) measure_body(b, params, i);

    // rotation
    RotationLaw<real> law = {{}, vec3(mass.inverse_inertia), scale3(mass.mass, gravity), {}};
    if (gyroscopic) law.ratios = gyroscopic_ratios(mass);
    if (pivoted) law.com_offset = vec3(b.pivots[i].com_offset_body);
    const Quat<real> old_q = quat(b.orientations[i]);
    const RotationState<real> state = rotation_step(law, RotationState<real>{old_q, unrotate3(old_q, w)}, params.dt);
    const Quat<real> q = state.q;
    if (pivoted || gyroscopic) w = rotate3(q, state.w);

    // translation
    if (pivoted) {
      const Pivot<real> pivot = b.pivots[i];
      const Vec3<real> com_offset = com_offset_world(pivot, q);
      x = add3(vec3(pivot.point_world), com_offset);
      v = cross3(w, com_offset);
    } else {
      const Vec3<real> displacement = add3(scale3(params.dt, v), scale3(real(0.5) * params.dt * params.dt, gravity));
      x = add3(x, displacement);
      v = add3(v, scale3(params.dt, gravity));
    }

    if (is_bad_velocity(v, w, params.speed_limit)) report_bad(b.counters, STATUS_BAD_FLIGHT, i);
    if (is_bad_pose(x, q)) report_bad(b.counters, STATUS_BAD_POSE, i);

    position.x = x.x;
    position.y = x.y;
    position.z = x.z;
    b.orientations[i] = make_vec4(q);
    set_inverse_inertia(motion, mass, info, q);
    store3(motion.v, v);
    store3(motion.w, w);
  }
}

}  // namespace lockstep::reference
