// Moves a body by an impulse and a moment, as displacements. kernels/joints/displace.h is the twin.
#pragma once

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

/// From the pose x, q, by inverse mass times the impulse and inverse inertia times the moment.
template <class real>
void displace(Buffers<real>& buffers, u32 body, Vec3<real> x, Quat<real> q, Vec3<real> impulse, Vec3<real> moment) {
  const Motion<real>& motion = buffers.motions[body];
  displace_by(buffers, body, x, q, scale3(motion.inverse_mass, impulse), apply_inverse_inertia(motion, moment));
}

}  // namespace lockstep::reference
