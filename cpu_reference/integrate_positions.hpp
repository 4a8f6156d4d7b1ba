// Poses follow the velocities for one sub-step:
//
//   x' = x + dt v_th,           v_th = (1 - th) v_old + th v_new                    survey eq. 1 and section 4.4
//   q' = (sin(|w_th| dt / 2) w_th / |w_th|, cos(|w_th| dt / 2)) q
//
// where "old" is the start of the sub-step and th = params.theta: 0 explicit Euler, 1 semi-implicit Euler, 1/2
// trapezoidal, exact for constant accelerations.
//
// Where a gyroscopic moment acts, integrate_velocities has computed the body-frame components of the new angular
// velocity: it is carried along as the body rotates. A body that no impulse has pushed since then rotates as
// computed there, which keeps its angular momentum. One that is held or hit rotates by w_th, as its joints and contacts
// were solved (at th = 1 that is about w itself, which leaves w as it is). At th = 1/2 they were solved in the middle
// of the sub-step: there w gets the gyroscopic moment of what they left, and from there it is carried on. So it does at
// th = 1 where joints hold the body, in the orientation of the start: what rotates fast about its length gained energy
// by the moment of a rotation that its joints do not allow. What was solved for is kept for measures, with a slack
// of -1. A body on a pivot only rotates, by w_th; its centre of mass follows.
#pragma once

#include "cpu_reference/gyroscopic.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/sleep.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
void integrate_positions(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;

  for (u32 i = 0; i < params.bodies; ++i) {
    const BodyInfo info = b.body_infos[i];
    if (info.kind == BODY_STATIC || is_asleep(b, i)) continue;
    const bool dynamic = info.kind == BODY_DYNAMIC;
    const bool pivoted = dynamic && is_pivoted(b.pivots, i);
    const bool gyroscopic = dynamic && is_gyroscopic(params, info);

    Motion<real>& motion = b.motions[i];
    Vec3<real> v = vec3(motion.v);
    Vec3<real> w = vec3(motion.w);
    if (is_bad_velocity(v, w, params.speed_limit)) report_bad(b.counters, STATUS_BAD_CONTACTS, i);
    const Velocity<real> previous = b.previous_velocities[i];
    const Vec3<real> mean_v = mean3(params.theta, vec3(previous.v), v);

    const Quat<real> old_q = quat(b.orientations[i]);
    const bool free = gyroscopic && !pivoted && is_free(b.free_rotations[i], w);
    const bool in_middle = acts_in_middle(params, info, pivoted);
    const bool jointed = gyroscopic && !pivoted && params.theta == real(1) && is_jointed(b.body_joint_starts, i);
    const Vec3<real> old_w = vec3(previous.w), solved_w = w;
    if ((in_middle || jointed) && !free) {
      const Quat<real> acting_q = in_middle ? orientation_in_middle(old_q, old_w, params.dt) : old_q;
      w = correct_gyroscopic_moment(params, b.masses[i], b.free_rotations[i], acting_q, old_w, w);
      b.free_rotations[i] = make_free_rotation(free_rotation(b.free_rotations[i]), solved_w, real(-1));
    }
    const Vec3<real> new_w = in_middle ? w : solved_w;
    const Quat<real> rotation =
        free ? free_rotation(b.free_rotations[i]) : rotation_by(mean3(params.theta, old_w, new_w), params.dt);
    const Quat<real> q = unit4(multiply4(rotation, old_q));
    const bool carried = free || jointed || (gyroscopic && params.theta != real(1));
    if (in_middle) w = rotate_by(rotation_by(old_w, real(-0.5) * params.dt), w);
    if (carried) w = rotate_by(rotation, w);

    Vec4<real>& position = b.positions[i];
    Vec3<real> x = vec3_of(position);
    if (pivoted) {
      const Pivot<real> pivot = b.pivots[i];
      const Vec3<real> com_offset = com_offset_world(pivot, q);
      x = add3(vec3(pivot.point_world), com_offset);
      v = cross3(w, com_offset);
    } else {
      x = add3(x, scale3(params.dt, mean_v));
    }
    if (is_bad_pose(x, q)) report_bad(b.counters, STATUS_BAD_POSE, i);

    position.x = x.x;
    position.y = x.y;
    position.z = x.z;
    b.orientations[i] = make_vec4(q);
    if (pivoted || carried) {
      store3(motion.v, v);
      store3(motion.w, w);
    }
  }
}

}  // namespace lockstep::reference
