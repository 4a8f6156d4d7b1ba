// Which scene a file belongs to.
#pragma once

#include <cstdint>

#include "host/scene/compile.hpp"

namespace lockstep {

/// What tells one compiled scene from another; how long its lists are does not count.
struct SceneIdentity {
  std::uint64_t settings = 0;   // a hash of the precision, the features, the parameters of a step and the oracle
  std::uint64_t constants = 0;  // of the constant buffers

  bool operator==(const SceneIdentity&) const = default;
};

/// Checkpoints of version 0.1.0 do not count the oracle.
enum class OracleIs { counted, left_out };

template <class real>
SceneIdentity identity_of(const InitialState<real>& state, OracleIs oracle = OracleIs::counted);

/// A hash of the persistent buffers, as far as they are in use.
template <class real>
std::uint64_t persistent_hash(const Buffers<real>& buffers);

}  // namespace lockstep
