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
  for (u32 i = 0u; i < 3u; ++i) global_store3(f->axes[i], now.axes[i]);
  global_store3(f->arm, link.is_b != 0u ? now.arm_b : now.arm_a);
  global_store3(f->parent_arm, link.is_b != 0u ? now.arm_a : now.arm_b);
  write_free_axis(info.free == FREE_ANGLE, now.free_axis, f);
  f->rise = now.rise;
  f->yield = (real)0;
  for (u32 i = 0u; i < JOINT_ROWS; ++i) f->error[i] = (info.locked >> i & 1u) != 0u ? sign * now.error[i] : (real)0;
  f->error[JOINT_ROWS] = rod ? sign * (now.coordinate - joint.low) : (real)0;
  return info.locked | (rod ? 1u << JOINT_ROWS : 0u);
}

#endif
