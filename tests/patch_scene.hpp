// Scenes of boxes whose contacts share one friction patch, for the tests of the friction model `patches`.
#pragma once

#include "tests/contact_scene.hpp"

namespace lockstep::test {

template <class real>
void use_patches(InitialState<real>& state) {
  state.features = with(with(state.features, Feature::patches), Feature::general_contacts);
  resize(state.buffers, state.sizes, state.features);
}

/// A heap of boxes and spheres that overlap, in motion, with impulses to start from, up to and with pack_points; soft
/// contacts where they are asked for.
template <class real>
InitialState<real> patch_pile(bool soft) {
  Random random(31);
  InitialState<real> state = make_worlds<real>({overlapping_bodies(random)}, 4096);
  use_patches(state);
  if (soft) {
    state.features = with(state.features, Feature::soft_contacts);
    resize(state.buffers, state.sizes, state.features);
    state.params.softness = real(0.3);
  }
  set_material(state, 0.4, 0.3);
  state.params.theta = 1;
  run_until_prepared(state);
  for (auto& start : state.buffers.start_impulses)
    start = {real(random.between(-0.2, 1)), real(random.between(-1, 1)), real(random.between(-1, 1)), 0};
  reference::run_stage(Stage::pack_points, state.buffers, state.params);
  return state;
}

/// A box on the ground under gravity, each contact with the same share of its weight.
template <class real>
InitialState<real> box_on_ground(Vector3 half_extents, double friction) {
  InitialState<real> state = make_worlds<real>({{box_body({0, 0, half_extents[2]}, half_extents), plane_body()}}, 16);
  use_patches(state);
  set_material(state, friction, 0);
  state.params.theta = 1;
  state.params.iterations = 100;  // so that what is left is the model's
  return state;
}

}  // namespace lockstep::test
