// What joints carry turns light bodies between them back, faster than a sub-step can follow: a joint that pulls by f at
// the arm r from the centre of a body turns it back by up to |f| |r| phi where it is rotated by phi. A taut chain
// swings across its tension so. Explicit steps stand a stiffness k of up to 4 I / h^2, whatever solves for the
// impulses.
//
// With k = sum |f| |r| of the impulses of the sub-step before, each principal moment of inertia counts, for the
// impulses of this one, for at least that of a rotation that it stands:
//   I' = max(I, h^2 k / 2)
// For the constraints let the bodies rotate by less than their sum could, the chain stands what each of its bodies
// does. What it cannot follow it damps, as an implicit step would, against the mean rotation of the body and of those
// in a row with it, so that what rotates as one keeps on:
//   w' = w - (1 - I / I') (w_0 - mean w_0)
// w_0 at the start of the sub-step. What rotates slowly enough, or carries little, is as it was, bit for bit.
//
// Tournier, Nesme, Gilles, Faure, Stable Constrained Dynamics, 2015, add the stiffness; Andrews, Teichmann, Kovecses,
// Geometric Stiffness for Real-time Constrained Multibody Dynamics, 2017, a diagonal of it where it is needed.
#pragma once

#include <cmath>

#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/sleep.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// The square of the force that a joint gave in the sub-step before, in time dt, N^2 s^2.
template <class real>
real squared_joint_impulse(const JointImpulseBlock<real>& given, u32 lane, u32 free) {
  real sum = 0;
  for (u32 i = 0; i < 3; ++i) sum = sum + given.locked[i][lane] * given.locked[i][lane];
  if (free == FREE_ANGLE || free == FREE_NOTHING) return sum;
  const real along = given.free[lane] + given.impedance[lane];
  return sum + along * along;
}

/// The mean angular velocity of a body and of those in a row from each of its joints, rad/s: up to STIFF_ROW of them,
/// the last the first that is not between two joints.
template <class real>
Vec3<real> mean_rotation(const Buffers<real>& b, u32 bodies, u32 body) {
  Vec3<real> sum = vec3(b.previous_velocities[body].w);
  real count = 1;
  for (u32 k = b.body_joint_starts[body]; k < b.body_joint_starts[body + 1]; ++k) {
    u32 joint = b.body_joints[k].joint, at = body;
    for (u32 hop = 0; hop < STIFF_ROW; ++hop) {
      const JointInfo& info = b.joint_infos[joint];
      at = info.body_a == at ? info.body_b : info.body_a;
      if (at >= bodies || at == body || b.body_infos[at].kind != BODY_DYNAMIC) break;
      sum = add3(sum, vec3(b.previous_velocities[at].w));
      count = count + 1;
      const u32 first = b.body_joint_starts[at];
      if (b.body_joint_starts[at + 1] - first != 2) break;
      joint = b.body_joints[b.body_joints[first].joint == joint ? first + 1 : first].joint;
    }
  }
  return scale3(real(1) / count, sum);
}

template <class real>
void add_geometric_stiffness(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;
  for (u32 i = 0; i < params.bodies; ++i) {
    const u32 first = b.body_joint_starts[i], end = b.body_joint_starts[i + 1];
    if (first == end || is_asleep(b, i) || is_pivoted(b.pivots, i)) continue;
    real moments = 0;  // of impulses, N m s
    for (u32 k = first; k < end; ++k) {
      const BodyJoint at = b.body_joints[k];
      const JointInfo& info = b.joint_infos[at.joint];
      const Joint<real>& joint = b.joints[at.joint];
      const Vec3<real> arm = vec3(info.body_a == i ? joint.anchor_a : joint.anchor_b);
      const real impulse = squared_joint_impulse(b.joint_impulses[at.slot / PACK], at.slot % PACK, info.free);
      moments = moments + std::sqrt(impulse * dot3(arm, arm));
    }

    const real least = real(STIFF_INERTIA_SHARE) * params.dt * moments;
    Mass<real> mass = b.masses[i];
    real damped[3];
    for (u32 axis = 0; axis < 3; ++axis) {
      const real share = least * mass.inverse_inertia[axis];
      damped[axis] = share > 1 ? real(1) - real(1) / share : real(0);
      if (share > 1) mass.inverse_inertia[axis] = real(1) / least;
    }
    if (!(damped[0] > 0 || damped[1] > 0 || damped[2] > 0)) continue;

    Motion<real>& motion = b.motions[i];
    const Quat<real> q = quat(b.orientations[i]);
    set_inverse_inertia(motion, mass, b.body_infos[i], q);
    const Vec3<real> mean = mean_rotation(b, params.bodies, i);
    const Vec3<real> own = unrotate3(q, sub3(vec3(b.previous_velocities[i].w), mean));
    store3(motion.w, sub3(vec3(motion.w), rotate3(q, multiply3(vec3(damped), own))));
  }
}

}  // namespace lockstep::reference
