// Bodies that nothing touches, velocities and poses in one stage of fourth order.
//
//   x' = x + dt v + dt^2/2 g,   v' = v + dt g                    exact for a constant gravity
//   q_dot = 1/2 q (w, 0),       w_dot = I^-1 (tau - w x I w)     survey eqs. 1 and 8, w and tau in the body frame
//
// The rotation takes one step of the classical Runge-Kutta method (Hairer, Norsett, Wanner, Solving ODE I, table 1.2),
// then q is brought back to unit length; between the stages its length is not 1, which costs no order because the
// equations keep it. A body on a pivot turns about it: I and tau = com_offset x m g are about the pivot.
#pragma once

#include "cpu_reference/gyroscopic.hpp"
#include "cpu_reference/measure.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// An orientation and the angular velocity in the body frame, or their rates.
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

template <class real>
RotationState<real> rotation_after(RotationState<real> start, RotationState<real> rate, real dt) {
  return {{start.q.x + dt * rate.q.x, start.q.y + dt * rate.q.y, start.q.z + dt * rate.q.z, start.q.w + dt * rate.q.w},
          add3(start.w, scale3(dt, rate.w))};
}
template <class real>
RotationState<real> rotation_rate(RotationLaw<real> law, RotationState<real> state) {
  const real h = real(0.5);
  const Vec3<real> moment = cross3(law.com_offset, unrotate3(state.q, law.weight));
  return {multiply4(state.q, Quat<real>{h * state.w.x, h * state.w.y, h * state.w.z, real(0)}),
          sub3(multiply3(law.inverse_inertia, moment), gyroscopic_term(law.ratios, state.w))};
}
template <class real>
RotationState<real> rotation_step(RotationLaw<real> law, RotationState<real> start, real dt) {
  const real half_dt = real(0.5) * dt;
  const RotationState<real> rate_1 = rotation_rate(law, start);
  const RotationState<real> rate_2 = rotation_rate(law, rotation_after(start, rate_1, half_dt));
  const RotationState<real> rate_3 = rotation_rate(law, rotation_after(start, rate_2, half_dt));
  const RotationState<real> rate_4 = rotation_rate(law, rotation_after(start, rate_3, dt));
  RotationState<real> end = rotation_after(start, rate_1, dt / real(6));
  end = rotation_after(end, rate_2, dt / real(3));
  end = rotation_after(end, rate_3, dt / real(3));
  end = rotation_after(end, rate_4, dt / real(6));
  end.q = unit4(end.q);
  return end;
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
