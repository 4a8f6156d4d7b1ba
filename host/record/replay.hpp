// Replays a recording somewhere else and compares the hash of every step.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "host/backends/checked_backend.hpp"
#include "host/record/recording_reader.hpp"

namespace lockstep {

/// Where to replay: the reference, where there is no device.
struct ReplayTarget {
  std::optional<DeviceInfo> device;
  DeviceOptions options;
};

/// Told where device and reference part, while both states are there.
template <class real>
using Parting = std::function<void(const Mismatch&, CheckedBackend<real>&)>;

/// Simulates the steps of a recording from the state that it begins with. Throws Error (comparison) at the first step
/// whose hash differs. The line names the stage, buffer, record and word where the step of the device and that of the
/// reference part, if they do; else the first recorded pose or velocity that is another. `done` is told after each
/// step, `parting` before a Mismatch is thrown. Returns the name() of the backend that it ran on.
template <class real>
std::string replay(const RecordingReader& recording, const ReplayTarget& target, const std::function<void(u32)>& done,
                   const Parting<real>& parting = {});

}  // namespace lockstep
