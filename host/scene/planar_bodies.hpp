// Bodies of 2-D worlds: a planar joint to the world leaves them three coordinates.
#pragma once

#include <optional>

#include "host/scene/scene.hpp"

namespace lockstep {

/// The joint that keeps the body of this index in its plane; none of a body that moves in all directions.
inline std::optional<JointDescription> planar_joint_of(const BodyDescription& body, u32 index) {
  if (body.plane_normal == Vector3{0, 0, 0}) return std::nullopt;
  JointDescription joint;
  joint.kind = JOINT_PLANAR;
  joint.body_b = index;
  joint.anchor_a = joint.anchor_b = body.position;
  joint.axis = body.plane_normal;
  return joint;
}

}  // namespace lockstep
