// Closes the joints of articulations by the poses of their bodies. cpu_reference/articulations/close_links.hpp is the
// twin.
#ifndef LOCKSTEP_ARTICULATION_CLOSE_LINKS_H
#define LOCKSTEP_ARTICULATION_CLOSE_LINKS_H

#include "articulations/solve_links.h"
#include "joints/displace.h"
#include "joints/joint_now.h"

// The joint of a link at the present poses: the rows that are closed.
static inline u32 write_link_joint_now(LinkInfo link, JointInfo info, const Joint joint, JointNow now,
                                       global LinkFactor* f) {
  const bool rod =
      info.free != FREE_NOTHING && joint.limited != (real)0 && joint.low == joint.high && !(joint.yield > (real)0);
  const real sign = link.is_b != 0u ? (real)1 : (real)-1;
  place_link_joint(link, info.free == FREE_ANGLE, now.axes, now.arm_a, now.arm_b, now.free_axis, now.rise, f);
  f->yield = (real)0;
  for (u32 i = 0u; i < JOINT_ROWS; ++i) f->error[i] = (info.locked >> i & 1u) != 0u ? sign * now.error[i] : (real)0;
  f->error[JOINT_ROWS] = rod ? sign * (now.coordinate - joint.low) : (real)0;
  return info.locked | (rod ? 1u << JOINT_ROWS : 0u);
}

static inline void close_link_up(u32 index, const StepParams params, global const LinkInfo* links,
                                 global const JointInfo* joint_infos, global const Joint* joints,
                                 global const real* screw_rises, global const real* rolling_radii,
                                 global const Motion* motions, global const Vec4* positions,
                                 global const Vec4* orientations, global LinkFactor* link_factors,
                                 global LinkMotion* link_motions) {
  const LinkInfo link = links[index];
  global LinkFactor* f = link_factors + index;
  u32 rows = 0u;  // one that floats has none, since it was factorised first
  if (link.joint != NONE) {
    const JointInfo info = joint_infos[link.joint];
    Vec3 x_a, x_b;
    Quat q_a, q_b;
    joint_pose(info.body_a, params.bodies, positions, orientations, &x_a, &q_a);
    joint_pose(info.body_b, params.bodies, positions, orientations, &x_b, &q_b);
    const JointNow now = joint_now(joints[link.joint], info.locked, info.free,
                                   joint_sizes(screw_rises, rolling_radii, link.joint), x_a, q_a, x_b, q_b);
    rows = write_link_joint_now(link, info, joints[link.joint], now, f);
  }
  factorise_link(link, rows, motions[link.body], link_factors, f);
  real off[LINK_ROWS];
  for (u32 i = 0u; i < LINK_ROWS; ++i) off[i] = f->error[i];
  ask_parent(link, off, link_factors, link_motions, f, link_motions + index);
}

#endif
