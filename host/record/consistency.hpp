// Whether the indices of a scene and a state that were read from a file point to what is there: kernels follow them
// without asking.
#pragma once

#include "host/scene/compile.hpp"

namespace lockstep {

/// Throws h5::Failed naming the first record of the constant buffers with an index or a kind out of range.
template <class real>
void expect_consistent_constants(const InitialState<real>& state);

/// The same of the persistent lists, which must be in their order too.
template <class real>
void expect_consistent_lists(const InitialState<real>& state);

}  // namespace lockstep
