// Replays a recording somewhere else and compares the hash of every step.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "host/backends/checked_backend.hpp"
#include "host/record/recording_reader.hpp"
#include "host/steppers/stepper.hpp"

namespace lockstep {

/// Told where device and reference part, while both states are there.
template <class real>
using Parting = std::function<void(const Mismatch&, CheckedBackend<real>&)>;

/// A replay that found every hash equal.
struct Replayed {
  std::string device;  // name() of the backend that it ran on
  Unsolved unsolved;   // by the oracle, as when it was recorded
};

/// Simulates the steps of a recording from the state that it begins with; those of an oracle are the oracle's again.
/// Throws Error (comparison) at the first step whose hash differs. The line names the stage, buffer, record and word
/// where the step of the device and that of the reference part, if they do; else the first recorded pose or velocity
/// that is another. `done` is told after each step, `parting` before a Mismatch is thrown.
template <class real>
Replayed replay(const RecordingReader& recording, const StepTarget& target, const std::function<void(u32)>& done,
                const Parting<real>& parting = {});

}  // namespace lockstep
