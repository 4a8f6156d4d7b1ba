// The table of joint kinds (kernels/joint_kinds.def) for the host.
#pragma once

#include <string>
#include <utility>

#include "kernels/types.h"

namespace lockstep {

inline constexpr std::pair<const char*, JointKind> joint_names[] = {
#define JOINT_KIND(name, NAME, ...) {#name, JOINT_##NAME},
#include "kernels/joint_kinds.def"
#undef JOINT_KIND
};

inline const char* name_of(JointKind kind) { return joint_names[kind].first; }

/// As a noun: a hinge, a planar joint.
inline std::string noun_of(JointKind kind) {
  const bool is_noun = kind == JOINT_HINGE || kind == JOINT_SLIDER || kind == JOINT_SCREW || kind == JOINT_SKATE;
  return std::string(name_of(kind)) + (is_noun ? "" : " joint");
}

/// Bits of the rows that a kind locks: linear x, y, z, angular x, y, z.
inline u32 locked_rows(JointKind kind) {
  constexpr u32 rows[] = {
#define JOINT_KIND(name, NAME, linear, angular, free) linear | angular << 3,
#include "kernels/joint_kinds.def"
#undef JOINT_KIND
  };
  return rows[kind];
}

/// The coordinate of a kind that limits, a motor, a spring and friction act on.
inline JointFree free_of(JointKind kind) {
  constexpr JointFree free[] = {
#define JOINT_KIND(name, NAME, linear, angular, free) free,
#include "kernels/joint_kinds.def"
#undef JOINT_KIND
  };
  return free[kind];
}

/// Whether a kind locks velocities that no condition on poses stands for (survey 2.2).
inline bool is_non_holonomic(JointKind kind) { return kind == JOINT_SKATE || kind == JOINT_ROLLING; }

/// Whether a kind has an axis, z of its frame: a universal joint has two.
inline bool has_axis(JointKind kind) {
  return free_of(kind) == FREE_ANGLE || free_of(kind) == FREE_TRAVEL || is_non_holonomic(kind);
}

/// Whether the angle of a kind is told from -pi to pi; that of a screw goes on over its turns.
inline bool has_angle_within_pi(JointKind kind) { return free_of(kind) == FREE_ANGLE && kind != JOINT_SCREW; }

}  // namespace lockstep
