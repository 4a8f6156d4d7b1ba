// Steps a scene on a backend: redoes a step that ran out of room, stops at one that went bad.
#pragma once

#include <memory>
#include <vector>

#include "host/backends/backend.hpp"
#include "host/scene/compile.hpp"

namespace lockstep {

template <class real>
class Simulation {
 public:
  /// `state` is what the backend was made from; its sizes and parameters are kept.
  Simulation(std::unique_ptr<Backend<real>> backend, const StepParams<real>& params)
      : backend_(std::move(backend)), params_(params) {}

  /// One time step. A list that was too short is made longer and the step redone, with the same bits as if it had been
  /// long enough. Throws Error naming body, stage and step when a velocity or a pose goes bad.
  void step();

  /// Hashes of the persistent state and of the poses of each world, computed where the state is.
  std::vector<WorldHash> world_hashes();

  /// Who began and who ceased to touch in the last step (kernels/types.h says in which order); nothing in a scene that
  /// does not ask for events (docs/events.md).
  std::vector<Event> events();

  Backend<real>& backend() { return *backend_; }
  const StepParams<real>& params() const { return params_; }
  const Counters& counters() const { return counters_; }  // of the last step
  u32 steps_done() const { return steps_done_; }
  u32 redone() const { return redone_; }  // steps that had to be redone so far

 private:
  std::unique_ptr<Backend<real>> backend_;
  StepParams<real> params_;
  Counters counters_ = {};
  u32 steps_done_ = 0, redone_ = 0;
};

}  // namespace lockstep
