// The hashes of a world's state and of its poses as numbers and as text; kernels/types.h keeps them in words.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "kernels/types.h"

namespace lockstep {

inline std::uint64_t state_hash(const WorldHash& hash) { return std::uint64_t{hash.state_high} << 32 | hash.state_low; }
inline std::uint64_t pose_hash(const WorldHash& hash) { return std::uint64_t{hash.pose_high} << 32 | hash.pose_low; }

/// 16 hex digits.
inline std::string hash_text(std::uint64_t hash) {
  char digits[17];
  std::snprintf(digits, sizeof(digits), "%016llx", static_cast<unsigned long long>(hash));
  return digits;
}

}  // namespace lockstep
