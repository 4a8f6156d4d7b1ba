// A contact at the current poses of its bodies. kernels/current_contact.h is the twin.
#pragma once

#include "cpu_reference/shapes/manifold.hpp"

namespace lockstep::reference {

/// A contact at the current poses: its point as an arm from either centre of mass, world axes. A contact on a face is
/// at the point of the other shape, so that the arm of a rolling sphere has exactly its radius; others are midway. Of
/// an impact later in the step each side keeps the point where it will be hit, however far apart the two still are. Of
/// edges that cross the point goes with one side, the one that rolls if there is one.
template <class real>
struct CurrentContact {
  Vec3<real> normal;
  real gap;
  Vec3<real> arm_a, arm_b;
};

template <class real>
CurrentContact<real> current_contact(const ContactPoint<real>& point, u32 frame, const Pose<real>& pose_a,
                                     const Pose<real>& pose_b) {
  const Vec3<real> anchor_a = rotate3(pose_a.orientation, vec3(point.anchor_a));
  const Vec3<real> anchor_b = rotate3(pose_b.orientation, vec3(point.anchor_b));
  const Vec3<real> offset_ab = sub3(pose_a.position, pose_b.position);
  const Vec3<real> d = sub3(add3(offset_ab, anchor_a), anchor_b);
  const real distance = length3(d);
  CurrentContact<real> current;
  current.normal = vec3(point.normal);
  if (frame == NORMAL_OF_A) current.normal = rotate3(pose_a.orientation, current.normal);
  if (frame == NORMAL_OF_B) current.normal = rotate3(pose_b.orientation, current.normal);
  if (frame == NORMAL_BETWEEN && distance > 0) current.normal = {d.x / distance, d.y / distance, d.z / distance};
  const real between = frame == NORMAL_BETWEEN ? distance : dot3(current.normal, d);
  current.gap = between - point.radius_a - point.radius_b;
  if (frame == NORMAL_OF_A || frame == NORMAL_FIXED_ON_B) {
    const real depth = frame == NORMAL_OF_A ? point.radius_b : point.radius_b + real(0.5) * current.gap;
    current.arm_b = add3(anchor_b, scale3(depth, current.normal));
    current.arm_a = sub3(current.arm_b, offset_ab);
  } else if (frame == NORMAL_OF_IMPACT) {
    current.arm_a = sub3(anchor_a, scale3(point.radius_a, current.normal));
    current.arm_b = add3(anchor_b, scale3(point.radius_b, current.normal));
  } else {
    const real depth = frame == NORMAL_OF_B ? point.radius_a : point.radius_a + real(0.5) * current.gap;
    current.arm_a = sub3(anchor_a, scale3(depth, current.normal));
    current.arm_b = add3(current.arm_a, offset_ab);
  }
  return current;
}

}  // namespace lockstep::reference
