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
  run_until_prepared(state);
  Random random(7);
  for (auto& start : state.buffers.start_impulses)
    start = {real(random.between(-0.2, 1)), real(random.between(-1, 1)), real(random.between(-1, 1)), 0};
  for (const Stage stage : {Stage::pack_points, Stage::prepare_contacts, Stage::warm_start})
    reference::run_stage(stage, state.buffers, state.params);
  return state;
}

/// Worlds of balls and boxes that fall on the ground, more in some than in others; none in a world of seed 0.
template <class real>
InitialState<real> dense_worlds(std::initializer_list<u32> seeds) {
  std::vector<std::vector<BodyDescription>> worlds;
  for (const u32 seed : seeds) {
    Random random(seed);
    worlds.push_back({plane_body()});
    for (u32 i = 0; i < 30 * seed; ++i) {
      const Vector3 at = {random.between(-1, 1), random.between(-1, 1), random.between(0.2, 2)};
      worlds.back().push_back(i % 2 == 0 ? sphere_body(at, 0.3) : box_body(at, {0.3, 0.2, 0.25}, random.turn()));
      worlds.back().back().velocity = random.vector(1);
    }
  }
  InitialState<real> state = make_worlds<real>(worlds, 8192);
  state.sizes.blocks = state.params.block_capacity = state.sizes.rows = state.params.row_capacity = 4096;
  resize(state.buffers, state.sizes, state.features);
  state.params.theta = 1;
  return state;
}

}  // namespace lockstep::test
