// What steps a world: a device, the reference, or an oracle in the place of its sweeps. Everything that makes steps has
// them made here, so that whatever computes a step can be recorded, replayed, drawn, exported and resumed.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "host/backends/canary.hpp"
#include "host/backends/device_backend.hpp"

namespace lockstep {

/// Where steps are computed: the reference, where there is no device.
struct StepTarget {
  std::optional<DeviceInfo> device;
  DeviceOptions options;
  bool is_auto = false;  // nobody asked for the device: the reference steps small scenes, and others at first
};

/// The target that `device` names, as `--device` does, for a state of this oracle: oracles run on the reference.
/// Throws Error (input) where it names a device for one, or names none.
StepTarget target_of(const std::string& device, const DeviceOptions& options, const OracleChoice& oracle);

template <class real>
struct Stepper {
  std::unique_ptr<Backend<real>> backend;
  std::function<CanaryVerdict()> canary;  // runs it on the device that computes; the reference has nothing to find
};

/// What steps this state there. Throws Error (input) for a scene that its oracle does not take, Error (device) where
/// the device cannot be used.
template <class real>
Stepper<real> make_stepper(const InitialState<real>& state, const StepTarget& target);
/// The same of a state that nobody else needs, without a copy of it.
template <class real>
Stepper<real> make_stepper(InitialState<real>&& state, const StepTarget& target);

}  // namespace lockstep
