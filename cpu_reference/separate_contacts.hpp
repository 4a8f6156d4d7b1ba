// Once a sub-step has moved the bodies, moves those of contacts that overlap apart, and leaves their velocities alone:
// a velocity would stay as energy (split impulses; nonlinear Gauss-Seidel as of close_joints). With the overlap beyond
// the slop measured at the present poses, and the rows J that the sub-step was solved with, a pair moves by
//   x += M^-1 J^T d,   d >= 0,   J M^-1 J^T d >= separation (-gap - slop) - h u+, complementary
// by `separation_passes` of projected Gauss-Seidel over its points, and no faster than the correction_limit; u+ is the
// speed at which a point parts already, which does it alone where it is fast. Points that are open may close their gap.
// Colour after colour, `position_sweeps` times.
#pragma once

#include "cpu_reference/joints/displace.hpp"
#include "cpu_reference/prepare_contacts.hpp"
#include "cpu_reference/solve_contact.hpp"
#include "cpu_reference/tolerances.hpp"

namespace lockstep::reference {

constexpr u32 separation_passes = 2;

/// The body as displacements are solved on it: v and w are how far it moves, m and rad.
template <class real>
Motion<real> at_rest(Motion<real> motion) {
  store3(motion.v, Vec3<real>{0, 0, 0});
  store3(motion.w, Vec3<real>{0, 0, 0});
  return motion;
}

/// How far a point is to move apart, m; less than 0: how far it may come closer.
template <class real>
real wanted_separation(const StepParams<real>& p, real gap, real inner_radius, real bounding_radius) {
  const real depth = -gap - pair_slop(p, inner_radius, bounding_radius);
  const real most = pair_correction_limit(p, bounding_radius) * p.dt, share = p.separation * depth;
  return depth > 0 ? (share < most ? share : most) : depth;
}

/// What of it is left to do for a point that overlaps and parts at this speed, m/s.
template <class real>
real beyond_parting(const StepParams<real>& p, real wanted, real speed) {
  return wanted > 0 && speed > 0 ? wanted - p.dt * speed : wanted;
}

template <class real>
void separate_pair(Buffers<real>& buffers, const StepParams<real>& params, u32 block, u32 lane) {
  const BlockBodies& bodies = buffers.block_bodies[block];
  const u32 a = bodies.body_a[lane], b = bodies.body_b[lane];
  const u32 first = buffers.block_rows[block].first, count = bodies.count[lane];
  const Pose<real> pose_a = make_pose(buffers.positions[a], buffers.orientations[a]);
  const Pose<real> pose_b = make_pose(buffers.positions[b], buffers.orientations[b]);
  PerPoint<real> wanted = {0, 0, 0, 0}, d = {0, 0, 0, 0};
  bool overlaps = false;
  for (u32 k = 0; k < count; ++k) {
    const PointBlock<real>& points = buffers.point_blocks[first + k];
    const real gap = current_contact(contact_point_of(points, lane), points.frame[lane], pose_a, pose_b).gap;
    wanted[k] = wanted_separation(params, gap, points.inner_radius[lane], points.bounding_radius[lane]);
    overlaps = overlaps || wanted[k] > 0;
  }
  if (!overlaps) return;
  overlaps = false;
  for (u32 k = 0; k < count; ++k) {
    const ContactArms<real> c = contact_arms<real>(buffers.contact_blocks[first + k], lane);
    wanted[k] = beyond_parting(params, wanted[k],
                               dot3(c.normal, velocity_at(c.arm_a, c.arm_b, buffers.motions[a], buffers.motions[b])));
    overlaps = overlaps || wanted[k] > 0;
  }
  if (!overlaps) return;
  Motion<real> moved_a = at_rest(buffers.motions[a]), moved_b = at_rest(buffers.motions[b]);
  for (u32 pass = 0; pass < separation_passes; ++pass) {
    for (u32 k = 0; k < count; ++k) {
      const ContactBlock<real>& row = buffers.contact_blocks[first + k];
      const ContactArms<real> c = contact_arms<real>(row, lane);
      const real moved = dot3(c.normal, velocity_at(c.arm_a, c.arm_b, moved_a, moved_b));
      const real next = d[k] + (wanted[k] - moved) / row.w_nn[lane], kept = next > 0 ? next : real(0);
      push_at(c.arm_a, c.arm_b, bodies.kind[lane], scale3(kept - d[k], c.normal), moved_a, moved_b);
      d[k] = kept;
    }
  }
  displace_by(buffers, a, pose_a.position, pose_a.orientation, vec3(moved_a.v), vec3(moved_a.w));
  displace_by(buffers, b, pose_b.position, pose_b.orientation, vec3(moved_b.v), vec3(moved_b.w));
}

template <class real>
void separate_contacts(Buffers<real>& buffers, const StepParams<real>& params) {
  if (step_aborted(buffers.counters)) return;
  for (u32 sweep = 0; sweep < params.position_sweeps; ++sweep)
    for_each_pair_slot(buffers,
                       [&](const BlockBodies&, u32 block, u32 lane) { separate_pair(buffers, params, block, lane); });
}

}  // namespace lockstep::reference
