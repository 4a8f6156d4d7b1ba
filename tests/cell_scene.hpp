// Scenes that are solved in cells.
#pragma once

#include "tests/jacobi_scene.hpp"

namespace lockstep::test {

template <class real>
void use_cells(InitialState<real>& state, double size) {
  state.features = with(state.features, Feature::partitions);
  state.buffers.cell_sizes.assign(state.sizes.worlds, real(size));
  resize(state.buffers, state.sizes, state.features);
}

/// Graphs of contacts whose bodies have places: cells of 1 m that hold one and many, and pairs that are in none.
template <class real>
InitialState<real> graphs_in_cells(u32 seed, std::initializer_list<std::pair<u32, u32>> bodies_and_contacts) {
  InitialState<real> state = random_worlds<real>(seed, bodies_and_contacts);
  Random random(seed + 1);
  for (Vec4<real>& at : state.buffers.positions)
    at = {real(random.between(-1.5, 1.5)), real(random.between(-1, 1)), real(random.between(0, 1)), 0};
  use_cells(state, 1);
  return state;
}

/// Up to the cells' schedules.
template <class real>
InitialState<real> scheduled(InitialState<real> state) {
  for (const Stage stage : {Stage::partition_contacts, Stage::schedule_contacts})
    reference::run_stage(stage, state.buffers, state.params);
  return state;
}

template <class real>
std::vector<u32> movable_bodies(const Buffers<real>& b, u32 contact) {
  std::vector<u32> bodies;
  for (const u32 body : {b.contacts[contact].body_a, b.contacts[contact].body_b})
    if (b.body_infos[body].kind == BODY_DYNAMIC) bodies.push_back(body);
  return bodies;
}

}  // namespace lockstep::test
