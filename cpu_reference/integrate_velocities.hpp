// Gravity and the gyroscopic moment act for one sub-step, before any contact does:
//
//   v' = v + dt (g + f / m)                                                             Newton, survey eq. 7
//   I (w' - w) + dt w_th x I w_th = dt tau,   w_th = (1 - th) w + th w'                 Euler, survey eq. 8
//
// with the force f and the torque tau that a user, and the particles of other bodies, put on the body (Load), taken at
// the old orientation, or at th = 1/2 at that in the middle of the step (gyroscopic.hpp, acts_in_middle).
//
// Euler's equation is solved in the body frame, for the components of w' in the frame that has turned by then; they
// are written back as seen from the old orientation. th = params.gyroscopic_theta: 0 explicit, 1 implicit (Catto,
// Numerical Methods, GDC 2015), 1/2 midpoint. How the body rotates if no impulse acts on it goes to free_rotations, for
// integrate_positions.
//
// A body on a pivot turns about it: I and the moment of gravity tau = com_offset x m g are about the pivot, and
// v = w x com_offset. Both Euler schemes (params.theta 0 and 1) take tau at the old orientation, the trapezoidal one
// half a step ahead, which makes it second order.
#pragma once

#include "cpu_reference/gyroscopic.hpp"
#include "cpu_reference/measure.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/sleep.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// What acts on body i: of a user, of its particles, or of both.
template <class real>
Load<real> load_of(const Buffers<real>& b, u32 i) {
  if (b.particle_loads.empty()) return b.loads.empty() ? Load<real>{} : b.loads[i];
  Load<real> load = b.particle_loads[i];
  if (!b.loads.empty()) {
    store3(load.force, add3(vec3(b.loads[i].force), vec3(load.force)));
    store3(load.torque, add3(vec3(b.loads[i].torque), vec3(load.torque)));
  }
  return load;
}

template <class real>
void integrate_velocities(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;

  for (u32 i = 0; i < params.bodies; ++i) {
    const BodyInfo info = b.body_infos[i];
    const Mass<real> mass = b.masses[i];
    const Quat<real> start_q = quat(b.orientations[i]);
    Motion<real>& motion = b.motions[i];
    Vec3<real> v = vec3(motion.v);
    Vec3<real> w = vec3(motion.w);
    b.previous_velocities[i] = make_velocity(v, w);
    if (params.substep == 0 && info.kind == BODY_DYNAMIC) measure_body(b, params, i);
    const bool in_middle = acts_in_middle(params, info, is_pivoted(b.pivots, i));
    const Quat<real> q = in_middle ? orientation_in_middle(start_q, w, params.dt) : start_q;
    set_inverse_inertia(motion, mass, info, q);

    FreeRotation<real> record = {};

    if (info.kind == BODY_DYNAMIC && !is_asleep(b, i)) {
      const Vec3<real> gravity = vec3_of(b.gravities[info.world]);
      const bool pivoted = is_pivoted(b.pivots, i);
      const bool gyroscopic = is_gyroscopic(params, info);
      const bool loaded = !b.loads.empty() || !b.particle_loads.empty();
      const Load<real> load = load_of(b, i);

      // rotation, in the body frame: delta_w is dt I^-1 tau
      if (pivoted || gyroscopic) {
        Vec3<real> delta_w = {};
        if (pivoted) {
          const real ahead = real(2) * params.theta * (real(1) - params.theta) * params.dt;
          const Vec3<real> moment = gravity_moment_body(b.pivots[i], mass, integrate_orientation(q, w, ahead), gravity);
          delta_w = scale3(params.dt, multiply3(vec3(mass.inverse_inertia), moment));
        }
        if (loaded) {
          Vec3<real> moment = vec3(load.torque);
          if (pivoted) moment = add3(moment, cross3(com_offset_world(b.pivots[i], q), vec3(load.force)));
          delta_w = add3(delta_w, scale3(params.dt, multiply3(vec3(mass.inverse_inertia), unrotate3(q, moment))));
        }
        Vec3<real> change = delta_w;
        FreeStep<real> step;
        if (gyroscopic) {
          const Vec3<real> w_body = unrotate3(q, w);
          step = gyroscopic_step(mass, w_body, delta_w, params.gyroscopic_theta, params.theta, params.dt);
          change = sub3(step.w, w_body);
        }
        w = add3(w, rotate3(q, change));  // rounding of its length, which comes with rotations, would add up
        if (gyroscopic && !pivoted) {
          const Vec3<real> axis = rotate3(start_q, Vec3<real>{step.rotation.x, step.rotation.y, step.rotation.z});
          const Vec3<real> gyroscopic_change = sub3(change, delta_w);
          record = make_free_rotation(Quat<real>{axis.x, axis.y, axis.z, step.rotation.w}, w,
                                      free_share<real> * dot3(gyroscopic_change, gyroscopic_change));
        }
      } else if (loaded) {
        w = add3(w, scale3(params.dt, apply_inverse_inertia(motion, vec3(load.torque))));
      }

      // translation
      if (pivoted) {
        v = cross3(w, com_offset_world(b.pivots[i], q));
      } else {
        Vec3<real> pull = gravity;
        if (loaded) pull = add3(pull, scale3(mass.inverse_mass, vec3(load.force)));
        v = add3(v, scale3(params.dt, pull));
      }

      if (is_bad_velocity(v, w, params.speed_limit)) report_bad(b.counters, STATUS_BAD_FORCES, i);
    }

    if (!b.free_rotations.empty()) b.free_rotations[i] = record;
    store3(motion.v, v);
    store3(motion.w, w);
  }
}

}  // namespace lockstep::reference
