// Moves a body by an impulse and a moment, as displacements. kernels/joints/displace.h is the twin.
#pragma once

#include "cpu_reference/gyroscopic.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// Moves a body from its pose by a displacement, m, and a rotation, rad. Bodies that cannot move are never written
/// (contract rule 8).
template <class real>
void displace_by(Buffers<real>& buffers, u32 body, Vec3<real> x, Quat<real> q, Vec3<real> displacement,
                 Vec3<real> rotation) {
  if (!(buffers.motions[body].inverse_mass > 0)) return;
  x = add3(x, displacement);
  q = correct_orientation(q, rotation);
  if (is_bad_pose(x, q)) report_bad(buffers.counters, STATUS_BAD_POSE, body);
  Vec4<real>& position = buffers.positions[body];
  position.x = x.x;
  position.y = x.y;
  position.z = x.z;
  buffers.orientations[body] = make_vec4(q);
}

/// From the pose x, q, by inverse mass times the impulse and inverse inertia times the moment. The angular velocity is
/// carried along where moments of inertia differ: it stays in the frame of the body, and with it the energy.
template <class real>
void displace(Buffers<real>& buffers, const StepParams<real>& params, u32 body, Vec3<real> x, Quat<real> q,
              Vec3<real> impulse, Vec3<real> moment) {
  Motion<real>& motion = buffers.motions[body];
  if (!(motion.inverse_mass > 0)) return;
  const Vec3<real> rotation = apply_inverse_inertia(motion, moment), half = scale3(real(0.5), rotation);
  displace_by(buffers, body, x, q, scale3(motion.inverse_mass, impulse), rotation);
  if (is_carried(params, buffers.body_infos[body]))
    store3(motion.w, rotate_by(Quat<real>{half.x, half.y, half.z, real(1)}, vec3(motion.w)));
}

}  // namespace lockstep::reference
