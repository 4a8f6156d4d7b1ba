// The table of joint kinds (kernels/joint_kinds.def) for the host.
#pragma once

#include <utility>

#include "kernels/types.h"

namespace lockstep {

/// Keys of a scene file that not all kinds have.
enum JointKey : u32 {
  JOINT_HAS_ANCHORS = 1,
  JOINT_HAS_AXIS = 2,
  JOINT_HAS_AXES = 4,
  JOINT_HAS_PITCH = 8,
  JOINT_HAS_RADIUS = 16
};

/// What a kind locks: poses, or velocities that no condition on poses stands for (survey 2.2).
enum class ConstraintLevel { POSES, VELOCITIES };

/// A row of the table.
struct JointKindInfo {
  const char* name;
  u32 locked;  // bits of the rows: linear x, y, z, angular x, y, z
  JointFree free;
  u32 keys;  // JointKey, or-ed
  ConstraintLevel level;
  const char *noun, *leaves;
};
inline constexpr JointKindInfo joint_kind_infos[] = {
#define JOINT_KIND(name, NAME, linear, angular, free, keys, level, reduced, noun, leaves) \
  {#name, linear | angular << 3, free, keys, ConstraintLevel::level, noun, leaves},
#include "kernels/joint_kinds.def"
#undef JOINT_KIND
};
constexpr const JointKindInfo& info(JointKind kind) { return joint_kind_infos[kind]; }

inline constexpr std::pair<const char*, JointKind> joint_names[] = {
#define JOINT_KIND(name, NAME, linear, angular, free, keys, level, reduced, noun, leaves) {#name, JOINT_##NAME},
#include "kernels/joint_kinds.def"
#undef JOINT_KIND
};

inline const char* name_of(JointKind kind) { return info(kind).name; }

/// As a noun: a hinge, a planar joint.
inline const char* noun_of(JointKind kind) { return info(kind).noun; }

inline u32 locked_rows(JointKind kind) { return info(kind).locked; }

/// The coordinate of a kind that limits, a motor, a spring and friction act on.
inline JointFree free_of(JointKind kind) { return info(kind).free; }

inline bool has_key(JointKind kind, JointKey key) { return (info(kind).keys & key) != 0; }

inline bool is_non_holonomic(JointKind kind) { return info(kind).level == ConstraintLevel::VELOCITIES; }

/// Whether a kind has an axis, z of its frame: a universal joint has two.
inline bool has_axis(JointKind kind) { return has_key(kind, JOINT_HAS_AXIS) || has_key(kind, JOINT_HAS_AXES); }

}  // namespace lockstep
