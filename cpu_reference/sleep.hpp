// Who sleeps, and who can disturb sleepers (docs/how_to/let_bodies_sleep.md). A dynamic body that sleeps keeps its
// pose, has no velocity, and takes part in nothing until somebody who moves touches it. kernels/sleep.h is the twin.
#pragma once

#include "host/buffers.hpp"

namespace lockstep::reference {

/// False for the null body, and in scenes where nobody sleeps.
template <class real>
bool is_asleep(const Buffers<real>& b, u32 body) {
  return body < b.sleepers.size() && b.sleepers[body].island < ISLAND_WAKES;
}

template <class real>
bool has_velocity(const Motion<real>& m) {
  return m.v[0] != 0 || m.v[1] != 0 || m.v[2] != 0 || m.w[0] != 0 || m.w[1] != 0 || m.w[2] != 0;
}

/// Whether the body is awake, or kinematic and on its way: of two bodies that touch, one that moves keeps the other
/// awake.
template <class real>
bool is_moving(const Buffers<real>& b, u32 body) {
  if (body >= b.body_infos.size()) return false;
  const u32 kind = b.body_infos[body].kind;
  return kind == BODY_DYNAMIC ? !is_asleep(b, body) : kind == BODY_KINEMATIC && has_velocity(b.motions[body]);
}

/// Whether the broad phase asks what the shape may touch: one that does not move touches nothing new. Triggers do
/// always, for they feel sleepers too.
template <class real>
bool looks_for_others(const Buffers<real>& b, u32 shape) {
  const ShapeInfo& info = b.shape_infos[shape];
  return b.sleepers.empty() || (info.flags & SHAPE_IS_TRIGGER) != 0 || is_moving(b, info.body);
}

/// Of two bodies that a joint holds or that touch, those of joints one after another.
template <class real, class Function>
void for_each_joined_pair(const Buffers<real>& b, Function&& function) {
  for (const JointLanes& lanes : b.joint_lanes) {
    for (u32 lane = 0; lane < PACK; ++lane) {
      if (lanes.joint[lane] != NONE) function(lanes.body_a[lane], lanes.body_b[lane]);
    }
  }
}

/// Whether the joint is of bodies that sleep: of one that sleeps the other does or cannot move.
template <class real>
bool joint_sleeps(const Buffers<real>& b, const JointInfo& joint) {
  return is_asleep(b, joint.body_a) || is_asleep(b, joint.body_b);
}

}  // namespace lockstep::reference
