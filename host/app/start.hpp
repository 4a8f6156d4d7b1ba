// What a run starts from: a compiled scene, or the state of a checkpoint of it.
#pragma once

#include <span>

#include "host/app/options.hpp"
#include "host/record/checkpoint.hpp"
#include "host/simulation.hpp"
#include "host/verdict.hpp"

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

/// Says on stderr what looks like a mistake in the first of the worlds, each line once
/// (docs/how_to/when_it_looks_wrong.md). Of a checkpoint the bodies are where the run before has left them.
template <class real>
void tell_suspicions(const Scene& scene, Start<real>& start);

/// A simulation of it, where the options say. The state is let go of.
template <class real>
Simulation<real> simulate(Start<real>& start, const SceneOptions& options);

/// Throws Error (comparison) where a solver left something unsolved: an oracle did not get to the residual that was
/// asked for, or sweeps did not get to a tolerance.
void expect_all_solved(const std::string& scene, const std::string& solver, const Unsolved& unsolved);

/// Says on stderr what is bad of the motion that has been drawn or exported, if anything is.
void tell_if_bad(const std::string& scene, const Verdict& verdict);

}  // namespace lockstep::app
