// Scenes that are solved by the dense Delassus matrix.
#pragma once

#include "host/report/residual.hpp"
#include "tests/jacobi_scene.hpp"

namespace lockstep::test {

template <class real>
void use_dense(InitialState<real>& state, u32 iterations = 10) {
  state.features = with(with(state.features, Feature::dense), Feature::general_contacts);
  state.sizes.coupled_tiles = 16 * tile_count(state.sizes.contacts, state.sizes.worlds);
  resize(state.buffers, state.sizes, state.features);
  state.params.iterations = iterations;
}

/// Ready to be solved: up to the warm start, from impulses that were drawn.
template <class real>
InitialState<real> started_dense(InitialState<real> state, u32 iterations) {
  use_dense(state, iterations);
  return started(std::move(state));
}

}  // namespace lockstep::test
