// The table of joint kinds (kernels/joint_kinds.def) for the host.
#pragma once

#include <utility>

#include "kernels/types.h"

namespace lockstep {

inline constexpr std::pair<const char*, JointKind> joint_names[] = {
#define JOINT_KIND(name, NAME, ...) {#name, JOINT_##NAME},
#include "kernels/joint_kinds.def"
#undef JOINT_KIND
};

inline const char* name_of(JointKind kind) { return joint_names[kind].first; }

/// Bits of the rows that a kind locks: linear x, y, z, angular x, y, z.
inline u32 locked_rows(JointKind kind) {
  constexpr u32 rows[] = {
#define JOINT_KIND(name, NAME, linear, angular, free) linear | angular << 3,
#include "kernels/joint_kinds.def"
#undef JOINT_KIND
  };
  return rows[kind];
}

/// The coordinate of a kind that limits, a motor and a spring act on.
inline JointFree free_of(JointKind kind) {
  constexpr JointFree free[] = {
#define JOINT_KIND(name, NAME, linear, angular, free) free,
#include "kernels/joint_kinds.def"
#undef JOINT_KIND
  };
  return free[kind];
}

}  // namespace lockstep
