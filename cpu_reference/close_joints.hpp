// Once a sub-step has moved the bodies, moves those of each joint back to where it is whole, and leaves their
// velocities alone, angular ones in the frame of the body (post-stabilisation: Cline and Pai, Post-Stabilization for
// Rigid Body Simulation with Contact and Constraints, 2003; here by sweeps of nonlinear Gauss-Seidel over the joints,
// colour after colour). With the error e of its locked rows at the present poses, and K = J M^-1 J^T of the joint
// alone, a solve moves its bodies by
//   K d = -e,   x += M^-1 J^T d,   q rotated by the angular part
// the least displacement, weighed by masses, that closes the joint to first order. It pushes as an impulse does, equal
// and opposite at b's anchor: the common centre of mass stays, and the displacements have no angular moment together.
//
// A free coordinate outside of its limits is brought to the nearer one, counted with what closing the locked rows does
// to it: as in the solver (cpu_reference/joints/solve_joint.hpp). Joints that are soft on purpose, and
// springs of free coordinates, are not touched. An angle that counts its revolutions is brought no farther than a
// radian from where its velocity brings it, so that they can be counted; the next sub-steps do the rest.
//
// Joints of articulations are closed all at once, before that (cpu_reference/articulations/close_links.hpp).
//
// The inverse inertias are those of the sub-step's start, on both sides of K: what the turn since then changes of them
// changes which displacement is taken, not that it closes the joint.
#pragma once

#include "cpu_reference/articulations/close_links.hpp"
#include "cpu_reference/joints/displace.hpp"
#include "cpu_reference/joints/factor.hpp"
#include "cpu_reference/joints/mobility.hpp"
#include "cpu_reference/joints/revolutions.hpp"
#include "cpu_reference/sleep.hpp"

namespace lockstep::reference {

/// How far the free coordinate has to move from x into its limits, or as far that way as it may.
template <class real>
real displacement_into_limits(const Joint<real>& joint, bool counted, real expected, real x) {
  if (joint.limited == 0 || joint.spring_compliance > 0) return 0;
  const real most = expected + real(JOINT_CLOSING_ANGLE), least = expected - real(JOINT_CLOSING_ANGLE);
  const real low = counted && joint.low > most ? most : joint.low;
  const real high = counted && joint.high < least ? least : joint.high;
  return x < low ? low - x : (x > high ? high - x : real(0));
}

template <class real>
void close_joint(Buffers<real>& buffers, const StepParams<real>& params, u32 index) {
  const JointInfo& info = buffers.joint_infos[index];
  const Joint<real>& joint = buffers.joints[index];
  if (joint.spring > 0 || joint_sleeps(buffers, info)) return;
  Vec3<real> x_a, x_b;
  Quat<real> q_a, q_b;
  joint_pose(buffers, params, info.body_a, x_a, q_a);
  joint_pose(buffers, params, info.body_b, x_b, q_b);
  CurrentJoint<real> current = current_joint(joint, info, joint_sizes(buffers, index), x_a, q_a, x_b, q_b);
  count_revolutions(buffers, params, index, current);
  const JointMobility<real> m =
      joint_mobility(current, info.free, buffers.motions[info.body_a], buffers.motions[info.body_b]);
  const JointFactor<real> factor = factorise(m.k, info.locked);

  const bool is_free = info.free != FREE_NOTHING;
  real d[JOINT_ROWS], coupling[JOINT_ROWS], response[JOINT_ROWS];
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    const bool locked = (info.locked >> i & 1) != 0;
    d[i] = locked ? -current.error[i] : real(0);
    coupling[i] = locked && is_free ? m.coupling[i] : real(0);
    response[i] = coupling[i];
  }
  solve_factor(factor, d);
  solve_factor(factor, response);
  real x = current.coordinate, coupled_mobility = 0;
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    x = x + coupling[i] * d[i];
    coupled_mobility = coupled_mobility + coupling[i] * response[i];
  }
  const real e = is_free ? m.free_mobility - coupled_mobility : real(0);
  const bool counted = counts_revolutions(buffers, info);
  const real d_free = e > 0 ? displacement_into_limits(joint, counted, current.expected, x) / e : real(0);
  for (u32 i = 0; i < JOINT_ROWS; ++i) d[i] = d[i] - response[i] * d_free;

  const bool angular = info.free == FREE_ANGLE;
  Vec3<real> impulse =
      add3(add3(scale3(d[0], current.axes[0]), scale3(d[1], current.axes[1])), scale3(d[2], current.axes[2]));
  const real about_z = current.lead != 0 ? -(current.lead * d[2]) : d[5];
  Vec3<real> moment =
      add3(add3(scale3(d[3], current.axes[0]), scale3(d[4], current.axes[1])), scale3(about_z, current.axes[2]));
  impulse = add3(impulse, scale3(angular ? real(0) : d_free, current.free_axis));
  moment = add3(moment, scale3(angular ? d_free : real(0), current.free_axis));
  displace(buffers, params, info.body_a, x_a, q_a, scale3(real(-1), impulse),
           scale3(real(-1), add3(cross3(current.arm_a, impulse), moment)));
  displace(buffers, params, info.body_b, x_b, q_b, impulse, add3(cross3(current.arm_b, impulse), moment));
}

template <class real>
void close_joints(Buffers<real>& buffers, const StepParams<real>& params) {
  if (step_aborted(buffers.counters)) return;
  for (u32 sweep = 0; sweep < params.position_sweeps; ++sweep) {
    close_articulations(buffers, params);
    for (const JointLanes& lanes : buffers.joint_lanes) {
      for (const u32 joint : lanes.joint) {
        if (joint != NONE && buffers.joint_infos[joint].direct == 0) close_joint(buffers, params, joint);
      }
    }
  }
}

}  // namespace lockstep::reference
