#include "tests/stage_harness.hpp"

#include "host/step.hpp"

namespace lockstep {

namespace {

// Whether users of a CPU have these lanes and this work-group.
template <class real>
bool is_usual(const DeviceOptions& launch) {
  return (launch.lanes == 0 || launch.lanes == (sizeof(real) == 4 ? 16 : 8)) && launch.work_group == 0;
}

// With all threads where a test does not say: a few bodies alone would take the one that calls, and nothing may depend
// on the others.
template <class real>
std::vector<DeviceOptions> launches_in(std::vector<DeviceOptions> launches, bool whole_step) {
  for (DeviceOptions& launch : launches) {
    launch.optimize = is_usual<real>(launch) && (whole_step || try_all());
    if (launch.threads == 0) launch.threads = test_device().compute_units;
  }
  return launches;
}

std::string describe(const DeviceOptions& options) {
  return "lanes " + std::to_string(options.lanes) + ", work-group " + std::to_string(options.work_group) +
         ", threads " + std::to_string(options.threads) + (options.optimize ? "" : ", not optimised");
}

}  // namespace

bool try_all() { return std::getenv("LOCKSTEP_TEST_FULL") != nullptr; }

template <class real>
void expect_twins_agree(const InitialState<real>& state, int steps, const std::vector<DeviceOptions>& launches) {
  for (const DeviceOptions& options : launches_in<real>(launches, true)) {
    SCOPED_TRACE(describe(options));
    try {
      CheckedBackend<real> backend(state, test_device(), options, {.poison = true});
      for (int i = 0; i < steps; ++i) step(backend, state.params);
    } catch (const Error& error) {
      ADD_FAILURE() << error.what();
    }
  }
}

template <class real>
Buffers<real> run_one_stage(Stage stage, const Buffers<real>& buffers, const Sizes& sizes, Features features,
                            const StepParams<real>& params, const std::vector<DeviceOptions>& launches) {
  InitialState<real> state = {buffers, sizes, features, params};
  resize(state.buffers, sizes, features);
  ReferenceBackend<real> reference(state);
  reference.run(stage, params);
  for (DeviceOptions options : launches_in<real>(launches, false)) {
    SCOPED_TRACE(describe(options));
    options.only = {stage};
    try {
      CheckedBackend<real> backend(state, test_device(), options, {.poison = true});
      backend.run(stage, params);
    } catch (const Error& error) {
      ADD_FAILURE() << error.what();
    }
  }
  return reference.buffers();
}

template void expect_twins_agree(const InitialState<float>&, int, const std::vector<DeviceOptions>&);
template void expect_twins_agree(const InitialState<double>&, int, const std::vector<DeviceOptions>&);
template Buffers<float> run_one_stage(Stage, const Buffers<float>&, const Sizes&, Features, const StepParams<float>&,
                                      const std::vector<DeviceOptions>&);
template Buffers<double> run_one_stage(Stage, const Buffers<double>&, const Sizes&, Features, const StepParams<double>&,
                                       const std::vector<DeviceOptions>&);

}  // namespace lockstep
