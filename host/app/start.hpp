// What a run starts from: a compiled scene, or the state of a checkpoint of it.
#pragma once

#include <span>

#include "host/app/options.hpp"
#include "host/record/checkpoint.hpp"

namespace lockstep::app {

template <class real>
struct Start {
  InitialState<real> state;
  u32 steps_done = 0;
};

/// Throws Error (input) where the checkpoint that the options name is none of this scene, or is as far as the run is to
/// go.
template <class real>
Start<real> make_start(std::span<const Scene> worlds, const SceneOptions& options);
template <class real>
Start<real> make_start(const Scene& scene, const SceneOptions& options) {
  return make_start<real>(std::span(&scene, 1), options);
}

/// On the device that the options name, or the reference.
template <class real>
std::unique_ptr<Backend<real>> make_backend(const InitialState<real>& state, const SceneOptions& options);

}  // namespace lockstep::app
