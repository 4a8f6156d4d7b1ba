// Numbers, vectors and kinds that all of the library names.
#pragma once

#include <array>
#include <cstdint>

namespace lockstep {

using u32 = std::uint32_t;

/// "No such body, joint or material".
inline constexpr u32 NONE = 0xffffffffu;

using Vector3 = std::array<double, 3>;
using Quaternion = std::array<double, 4>;  // x y z w; a unit quaternion rotates body into world coordinates

enum BodyKind { BODY_STATIC = 0, BODY_KINEMATIC = 1, BODY_DYNAMIC = 2 };

/// A mesh is simulated by its triangles or, with `particles`, as particles. SHAPE_FACET is a surface of triangles.
enum ShapeKind {
  SHAPE_SPHERE = 0,
  SHAPE_CAPSULE = 1,
  SHAPE_BOX = 2,
  SHAPE_CYLINDER = 3,
  SHAPE_HULL = 4,
  SHAPE_PLANE = 5,
  SHAPE_KINDS = 6,  // how many are simulated; the rest are kinds of scenes alone
  SHAPE_LAST_KIND = SHAPE_KINDS - 1,
  SHAPE_MESH = 6,
  SHAPE_FACET = 7
};

/// What each leaves free, and the coordinate that limits, motors and springs act on: docs/reference/scene_format.md.
enum JointKind {
  JOINT_BALL = 0,
  JOINT_HINGE = 1,
  JOINT_SLIDER = 2,
  JOINT_FIXED = 3,
  JOINT_DISTANCE = 4,
  JOINT_CYLINDRICAL = 5,
  JOINT_PLANAR = 6,
  JOINT_UNIVERSAL = 7,
  JOINT_SCREW = 8,
  JOINT_SKATE = 9,
  JOINT_ROLLING = 10,
  JOINT_KINDS = 11
};

enum EventKind {
  EVENT_CONTACT_BEGIN = 0,
  EVENT_CONTACT_END = 1,
  EVENT_TRIGGER_ENTER = 2,
  EVENT_TRIGGER_LEAVE = 3,
  EVENT_IMPACT = 4,
  EVENT_KINDS = 5
};

/// What an impact obeys (docs/theory/impacts.md).
enum ImpactLaw {
  IMPACT_NEWTON = 0,
  IMPACT_POISSON = 1,
  IMPACT_STRONGE = 2,
  IMPACT_CHATTERJEE_RUINA = 3,
  IMPACT_LAWS = 4
};

}  // namespace lockstep
