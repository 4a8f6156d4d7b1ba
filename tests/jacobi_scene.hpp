// Scenes that are solved by Jacobi's method.
#pragma once

#include "tests/contact_scene.hpp"

namespace lockstep::test {

template <class real>
void use_jacobi(InitialState<real>& state) {
  state.features = with(state.features, Feature::jacobi);
  resize(state.buffers, state.sizes, state.features);
}

/// A heap of boxes and spheres that overlap, in motion, above the ground or without one.
template <class real>
InitialState<real> heap(u32 seed, u32 count, u32 pairs, bool grounded = true) {
  Random random(seed);
  std::vector<BodyDescription> bodies;
  if (grounded) bodies.push_back(plane_body());
  const double side = std::sqrt(count / 20.0);
  for (u32 i = 0; i < count; ++i) {
    const Vector3 at = {random.between(-side, side), random.between(-side, side), random.between(0.2, 1.5)};
    const Vector3 size = {random.between(0.2, 0.4), random.between(0.2, 0.4), random.between(0.2, 0.4)};
    bodies.push_back(i % 2 == 0 ? sphere_body(at, 0.3) : box_body(at, size, random.rotation()));
    bodies.back().velocity = random.vector(1);
    bodies.back().angular_velocity = random.vector(2);
    if (grounded && i % 10 == 9) bodies.back().kind = BODY_KINEMATIC;
  }
  InitialState<real> state = make_worlds<real>({bodies}, pairs);
  state.sizes.blocks = state.params.block_capacity = MAX_COLORS + pairs / 4;
  state.sizes.rows = state.params.row_capacity = MAX_COLORS + pairs / 2;
  resize(state.buffers, state.sizes, state.features);
  set_material(state, 0.4, 0.3);
  state.params.theta = 1;
  return state;
}

/// Worlds of so many balls and boxes that fall on the ground.
template <class real>
InitialState<real> heaps(std::initializer_list<u32> counts) {
  std::vector<std::vector<BodyDescription>> worlds;
  for (const u32 count : counts) {
    Random random(count);
    worlds.push_back({plane_body()});
    for (u32 i = 0; i < count; ++i) {
      const Vector3 at = {random.between(-1, 1), random.between(-1, 1), random.between(0.2, 2)};
      worlds.back().push_back(i % 2 == 0 ? sphere_body(at, 0.3) : box_body(at, {0.3, 0.2, 0.25}, random.rotation()));
      worlds.back().back().velocity = random.vector(1);
    }
  }
  InitialState<real> state = make_worlds<real>(worlds, 8192);
  state.sizes.blocks = state.params.block_capacity = state.sizes.rows = state.params.row_capacity = 4096;
  resize(state.buffers, state.sizes, state.features);
  state.params.theta = 1;
  return state;
}

/// Up to the packed constraint stream, with impulses to start from.
template <class real>
InitialState<real> prepared_heap(u32 seed, u32 count, u32 pairs, bool uses_patches) {
  InitialState<real> state = heap<real>(seed, count, pairs);
  if (uses_patches) state.features = with(state.features, Feature::patches);
  use_jacobi(state);
  run_until_prepared(state);
  draw_start_impulses(seed, state);
  reference::run_stage(Stage::pack_points, state.buffers, state.params);
  return state;
}

}  // namespace lockstep::test
