// What joints carry turns light bodies between them back, faster than a sub-step can follow: a joint that pulls by f at
// the arm r from the centre of a body turns it back by up to |f| |r| phi where it is rotated by phi. A taut chain
// swings across its tension so. Explicit steps are stable up to a stiffness k of 4 I / h^2, whatever solves for
// the impulses.
//
// With the impulses f h of the sub-step before, in the frame of its principal axes, a body is stiffened about x by
//   k_x = sum |f_y r_y| + |f_z r_z|,   and by no more than   sum |f_x r_y + f_y r_x| / 2   with y, as with z
// Where h^2 k / 2 is more than I for some axis, each principal moment of inertia counts, for the impulses of this
// sub-step, for at least
//   I' = h^2 / 2 (k + what couples the axis with the others)
// Constraints only take freedom away, so that a chain is stable where each of its bodies is. What a sub-step cannot
// follow is damped, as an implicit step would, against the mean rotation of the body and of those
// in a row with it that are as light, so that what rotates as one is not:
//   w' = w - (1 - I / I') (w_0 - mean w_0)
// w_0 at the start of the sub-step. What rotates slowly enough, or carries little, is as it was, bit for bit.
//
// Tournier, Nesme, Gilles, Faure, Stable Constrained Dynamics, 2015, add the stiffness; Andrews, Teichmann, Kovecses,
// Geometric Stiffness for Real-time Constrained Multibody Dynamics, 2017, a diagonal of it where it is needed.
#pragma once

#include <algorithm>
#include <cmath>

#include "cpu_reference/gyroscopic.hpp"
#include "cpu_reference/joints/current_joint.hpp"
#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/sleep.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// What stiffens a body, by the impulses of the sub-step before, N m s: k h for each principal axis, and a bound of
/// what couples it with the two others.
template <class real>
struct Stiffness {
  Vec3<real> own, coupled;
};

template <class real>
Stiffness<real> geometric_stiffness(const Buffers<real>& b, const StepParams<real>& params, u32 body) {
  Stiffness<real> sum = {};
  const Quat<real> q = quat(b.orientations[body]);
  for (u32 k = b.body_joint_starts[body]; k < b.body_joint_starts[body + 1]; ++k) {
    const BodyJoint at = b.body_joints[k];
    const JointInfo& info = b.joint_infos[at.joint];
    const JointImpulseBlock<real>& given = b.joint_impulses[at.slot / PACK];
    const u32 lane = at.slot % PACK;
    Vec3<real> x_a, x_b;
    Quat<real> q_a, q_b;
    joint_pose(b, params, info.body_a, x_a, q_a);
    joint_pose(b, params, info.body_b, x_b, q_b);
    const CurrentJoint<real> joint =
        current_joint(b.joints[at.joint], info, joint_sizes(b, at.joint), x_a, q_a, x_b, q_b);
    Vec3<real> impulse = {};
    for (u32 row = 0; row < 3; ++row) impulse = add3(impulse, scale3(given.locked[row][lane], joint.axes[row]));
    if (info.free == FREE_TRAVEL || info.free == FREE_LENGTH)
      impulse = add3(impulse, scale3(given.free[lane] + given.impedance[lane], joint.free_axis));
    const Vec3<real> f = unrotate3(q, impulse), r = unrotate3(q, info.body_a == body ? joint.arm_a : joint.arm_b);
    const real x = std::fabs(f.x * r.x), y = std::fabs(f.y * r.y), z = std::fabs(f.z * r.z);
    const real yz = real(0.5) * std::fabs(f.y * r.z + f.z * r.y), zx = real(0.5) * std::fabs(f.z * r.x + f.x * r.z),
               xy = real(0.5) * std::fabs(f.x * r.y + f.y * r.x);
    sum.own = add3(sum.own, Vec3<real>{y + z, z + x, x + y});
    sum.coupled = add3(sum.coupled, Vec3<real>{xy + zx, yz + xy, zx + yz});
  }
  return sum;
}

template <class real>
real sum_of_sizes(Vec3<real> v) {
  return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z);
}

/// Whether the body carries so little that it is not too light about any axis, whatever its joints are turned by: as
/// |f_y r_y| + |f_z r_z| <= |f| |r|, and no vector is longer than the sum of its components' sizes along any axes.
template <class real>
bool carries_little(const Buffers<real>& b, const StepParams<real>& params, u32 body) {
  real bound = 0;
  for (u32 k = b.body_joint_starts[body]; k < b.body_joint_starts[body + 1]; ++k) {
    const BodyJoint at = b.body_joints[k];
    const JointInfo& info = b.joint_infos[at.joint];
    const JointImpulseBlock<real>& given = b.joint_impulses[at.slot / PACK];
    const u32 lane = at.slot % PACK;
    real impulse = sum_of_sizes(Vec3<real>{given.locked[0][lane], given.locked[1][lane], given.locked[2][lane]});
    if (info.free == FREE_TRAVEL || info.free == FREE_LENGTH)
      impulse = impulse + (std::fabs(given.free[lane]) + std::fabs(given.impedance[lane]));
    real arm = sum_of_sizes(vec3(b.joints[at.joint].anchor_b)) + joint_sizes(b, at.joint).radius;
    if (info.body_a == body) {
      const Vec3<real> x_b = info.body_b < params.bodies ? vec3_of(b.positions[info.body_b]) : Vec3<real>{0, 0, 0};
      arm = arm + sum_of_sizes(sub3(x_b, vec3_of(b.positions[body])));
    }
    bound = bound + impulse * arm;
  }
  const Vec3<real> inverse = vec3(b.masses[body].inverse_inertia);
  constexpr real one_less_rounding = real(0.984375);
  return real(STIFF_INERTIA_SHARE) * params.dt * bound * sum_of_sizes(inverse) < one_less_rounding;
}

/// Whether it swings too fast for a sub-step: I < h^2 k / 2 about some axis.
template <class real>
bool is_too_light(const Mass<real>& mass, Vec3<real> stiffness, real dt) {
  const Vec3<real> shares = multiply3(scale3(real(STIFF_INERTIA_SHARE) * dt, stiffness), vec3(mass.inverse_inertia));
  return shares.x > 1 || shares.y > 1 || shares.z > 1;
}

/// The mean angular velocity of a body and of those in a row from each of its joints, rad/s: up to STIFF_ROW that are
/// between two joints and too light.
template <class real>
Vec3<real> mean_rotation(const Buffers<real>& b, const StepParams<real>& params, u32 body) {
  Vec3<real> sum = vec3(b.previous_velocities[body].w);
  real count = 1;
  for (u32 k = b.body_joint_starts[body]; k < b.body_joint_starts[body + 1]; ++k) {
    u32 joint = b.body_joints[k].joint, at = body;
    for (u32 hop = 0; hop < STIFF_ROW; ++hop) {
      const JointInfo& info = b.joint_infos[joint];
      at = info.body_a == at ? info.body_b : info.body_a;
      if (at >= params.bodies || at == body) break;
      const u32 first = b.body_joint_starts[at];
      if (b.body_joint_starts[at + 1] - first != 2) break;
      if (!is_too_light(b.masses[at], geometric_stiffness(b, params, at).own, params.dt)) break;
      sum = add3(sum, vec3(b.previous_velocities[at].w));
      count = count + 1;
      joint = b.body_joints[b.body_joints[first].joint == joint ? first + 1 : first].joint;
    }
  }
  return scale3(real(1) / count, sum);
}

template <class real>
void add_geometric_stiffness(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;
  for (u32 i = 0; i < params.bodies; ++i) {
    if (b.body_joint_starts[i] == b.body_joint_starts[i + 1] || is_asleep(b, i) || is_pivoted(b.pivots, i)) continue;
    if (carries_little(b, params, i)) continue;
    const Stiffness<real> stiffness = geometric_stiffness(b, params, i);
    Mass<real> mass = b.masses[i];
    if (!is_too_light(mass, stiffness.own, params.dt)) continue;

    Vec3<real> k = add3(stiffness.own, stiffness.coupled);
    if (b.body_infos[i].isotropic != 0) k.x = k.y = k.z = std::max(k.x, std::max(k.y, k.z));
    const real least[3] = {k.x, k.y, k.z};
    real damped[3];
    for (u32 axis = 0; axis < 3; ++axis) {
      const real inertia = real(STIFF_INERTIA_SHARE) * params.dt * least[axis];
      const real share = inertia * mass.inverse_inertia[axis];
      damped[axis] = share > 1 ? real(1) - real(1) / share : real(0);
      if (share > 1) mass.inverse_inertia[axis] = real(1) / inertia;
    }
    Motion<real>& motion = b.motions[i];
    Quat<real> q = quat(b.orientations[i]);
    if (acts_in_middle(params, b.body_infos[i], false))
      q = orientation_in_middle(q, vec3(b.previous_velocities[i].w), params.dt);
    set_inverse_inertia(motion, mass, b.body_infos[i], q);
    const Vec3<real> own = unrotate3(q, sub3(vec3(b.previous_velocities[i].w), mean_rotation(b, params, i)));
    const Vec3<real> lost = multiply3(vec3(damped), own);
    if (dot3(lost, lost) > real(0)) b.previous_velocities[i].damped = real(1);
    store3(motion.w, sub3(vec3(motion.w), rotate3(q, lost)));
  }
}

}  // namespace lockstep::reference
