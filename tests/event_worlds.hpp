// Small worlds whose events, triggers, impacts and queries are looked at, step by step, in the reference.
#pragma once

#include <string>

#include "host/backends/reference_backend.hpp"
#include "host/simulation.hpp"
#include "tests/collision_states.hpp"

namespace lockstep::test {

/// A body that only feels.
inline BodyDescription trigger_body(BodyDescription body) {
  body.kind = BODY_STATIC;
  for (ShapeDescription& shape : body.shapes) shape.trigger = true;
  return body;
}

/// The worlds of make_worlds() with the features that their shapes ask for, and events.
template <class real>
InitialState<real> make_event_worlds(const std::vector<std::vector<BodyDescription>>& worlds, u32 pairs) {
  InitialState<real> state = make_worlds<real>(worlds, pairs);
  state.features = with(state.features, Feature::events);
  for (const ShapeInfo& info : state.buffers.shape_infos) {
    if (info.flags & SHAPE_IS_TRIGGER) state.features = with(state.features, Feature::triggers);
    if (info.flags & SHAPE_IS_CONTINUOUS) state.features = with(state.features, Feature::continuous);
  }
  resize(state.buffers, state.sizes, state.features);
  return state;
}

template <class real>
Simulation<real> simulate_in_reference(const InitialState<real>& state) {
  return Simulation<real>(std::make_unique<ReferenceBackend<real>>(state), state.params);
}

/// "begin 1 0" and so on: the kind and the bodies.
inline std::string describe(const Event& event) {
  const char* kinds[] = {"begin", "end", "enter", "leave"};
  return std::string(kinds[event.kind]) + " " + std::to_string(event.body_a) + " " + std::to_string(event.body_b);
}

}  // namespace lockstep::test
