#include "host/steppers/stepper.hpp"

#include <algorithm>

#include "host/backends/reference_backend.hpp"
#include "host/error.hpp"
#include "host/steppers/oracles.hpp"
#include "host/steppers/starting_backend.hpp"

namespace lockstep {

StepTarget target_of(const std::string& device, const DeviceOptions& options, const OracleChoice& oracle) {
  if (!oracle) return {select_device(device), options, device == "auto"};
  if (device != "auto" && device != "reference")
    throw Error(Failure::input, "--device",
                oracle.name + " is an oracle, which runs on the reference only; leave --device out");
  return {std::nullopt, options};
}

namespace {

// Up to this many bodies, shapes, joints and particles the reference steps about as fast as a device, and nothing is
// built for it (docs/lab/performance.md).
constexpr u32 items_of_reference = 16;

// Whether nobody asks for the device, or for how it runs.
bool may_take_reference(const StepTarget& target) {
  const DeviceOptions& wanted = target.options;
  return target.is_auto && !wanted.lanes && !wanted.work_group && !wanted.threads && !wanted.substeps &&
         !wanted.profile;
}

bool is_for_reference(const Sizes& sizes, const StepTarget& target) {
  return !target.device || (may_take_reference(target) && std::max({sizes.bodies, sizes.shapes, sizes.joints,
                                                                    sizes.particles}) <= items_of_reference);
}

// `State` is a constant state, or one that is let go of.
template <class real, class State>
Stepper<real> stepper_of(State&& state, const StepTarget& target) {
  const auto nothing = [] { return CanaryVerdict(); };
  if (state.oracle) {
    if constexpr (sizeof(real) == sizeof(double))
      return {make_oracle(std::forward<State>(state), target.options.profile), nothing};
    else
      throw Error(Failure::input, "precision", state.oracle.name + " is an oracle, which works in double only");
  }
  if (is_for_reference(state.sizes, target))
    return {std::make_unique<ReferenceBackend<real>>(std::forward<State>(state), target.options.profile), nothing};
  if (may_take_reference(target) && !target.options.waits_for_kernels &&
      !has_built(state, *target.device, target.options))
    return {std::make_unique<StartingBackend<real>>(state, *target.device, target.options), nothing};
  auto backend = std::make_unique<DeviceBackend<real>>(std::forward<State>(state), *target.device, target.options);
  const auto canary = [device = *target.device, lanes = backend->lanes(), threads = backend->threads()] {
    return run_canary(device, sizeof(real) == sizeof(double), lanes, threads);
  };
  return {std::move(backend), canary};
}

}  // namespace

template <class real>
Stepper<real> make_stepper(const InitialState<real>& state, const StepTarget& target) {
  return stepper_of<real>(state, target);
}
template <class real>
Stepper<real> make_stepper(InitialState<real>&& state, const StepTarget& target) {
  return stepper_of<real>(std::move(state), target);
}

template Stepper<float> make_stepper(const InitialState<float>&, const StepTarget&);
template Stepper<double> make_stepper(const InitialState<double>&, const StepTarget&);
template Stepper<float> make_stepper(InitialState<float>&&, const StepTarget&);
template Stepper<double> make_stepper(InitialState<double>&&, const StepTarget&);

}  // namespace lockstep
