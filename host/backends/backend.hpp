// What the pipeline runs on: the OpenCL device, the C++ reference, both beside each other, or the reference with an
// oracle in the place of its sweeps. host/steppers/stepper.hpp makes them.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/stages.hpp"
#include "host/unsolved.hpp"

namespace lockstep {

struct Measures;  // host/report/measures.hpp

using Counters = std::array<u32, COUNTER_COUNT>;

/// By Stage; the last one is all sub-steps, where they are one launch.
using StageSeconds = std::array<double, stage_count + 1>;

/// A copy of buffers, where the backend that made it has them.
class SavedBuffers {
 public:
  virtual ~SavedBuffers() = default;
};

template <class real>
class Backend {
 public:
  virtual ~Backend() = default;

  /// Runs, or enqueues, one stage; nothing when the scene's features do not ask for it.
  virtual void run(Stage stage, const StepParams<real>& params) = 0;

  /// The counters of the step, after everything enqueued has ended.
  virtual Counters counters() = 0;

  /// Makes room for longer lists after a step that ran out of it; constant and persistent contents are kept.
  virtual void grow(const Sizes& sizes) = 0;

  /// Adds a feature that the scene did not ask for to those of the running simulation: its buffers (empty, grow() makes
  /// room) and its stages, which are built now. For stages outside of step() only.
  virtual void enable(Feature feature) = 0;

  /// Host copies of the named buffers as they are now (all live elements); the others may be stale.
  virtual const Buffers<real>& download(std::span<const Buffer> wanted) = 0;

  /// Overwrites a buffer from the host's copy in `buffers`, for resuming and for tests.
  virtual void upload(Buffer buffer, const Buffers<real>& buffers) = 0;

  /// A copy of the named buffers as they are now, for restore(). On the host, unless the backend has another place.
  virtual std::unique_ptr<SavedBuffers> save(std::span<const Buffer> wanted);
  /// Puts back a copy that this backend made. Lists may have become longer since.
  virtual void restore(SavedBuffers& saved);

  /// How often a buffer has been overwritten: whoever knows the state by what it was asks whether it still is that.
  u32 uploads() const { return uploads_; }

  virtual const Sizes& sizes() const = 0;
  virtual Features features() const = 0;

  /// "reference", or the device's name.
  virtual std::string name() const = 0;

  /// Seconds spent in each stage since the start; zeros unless profiling was asked for.
  virtual StageSeconds stage_seconds() const = 0;

  /// How many steps have been run by each plan that there is; empty where there is but one.
  virtual std::vector<std::pair<std::string, u32>> steps_by_plan() const { return {}; }

  /// What has been left unsolved so far.
  virtual Unsolved unsolved() const { return {}; }
  /// It goes back to a state before which this had been left.
  virtual void set_unsolved(const Unsolved&) {}

  /// Puts the residual of a backend that measures its own in the place of that of the constraint system.
  virtual void take_own_residual(Measures&) {}

 protected:
  u32 uploads_ = 0;
};

}  // namespace lockstep
