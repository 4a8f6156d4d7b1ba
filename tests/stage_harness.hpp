// Runs stages on the device and in the reference beside each other, for the KernelMatchesReference half of the tests.
//
//   TEST(UpdateBounds, KernelMatchesReference) {
//     const Buffers<float> after = run_one_stage<float>(Stage::update_bounds, buffers, sizes, features, params);
//     ...physics of `after`...
//   }
//   TEST(Pile, TwinsAgree) { expect_twins_agree(compile<float>(read_scene("pile")), 50); }
//
// The device is `auto`, or what $LOCKSTEP_TEST_DEVICE says; a machine without any OpenCL device fails these tests.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <utility>
#include <vector>

#include "host/backends/checked_backend.hpp"
#include "host/step.hpp"

namespace lockstep {

inline DeviceInfo test_device() {
  setenv("LOCKSTEP_CACHE", "", 0);  // tests leave no files with the user; pocl keeps what they build
  const char* wanted = std::getenv("LOCKSTEP_TEST_DEVICE");
  const auto device = select_device(wanted ? wanted : "auto");
  if (!device) throw Error(Failure::device, "tests", "need an OpenCL device (Debian: pocl-opencl-icd)");
  return *device;
}

/// From lane counts and work-groups.
inline std::vector<DeviceOptions> launch_options(std::initializer_list<std::pair<u32, u32>> list) {
  std::vector<DeviceOptions> all;
  for (const auto& [lanes, work_group] : list) {
    all.emplace_back();
    all.back().lanes = lanes;
    all.back().work_group = work_group;
  }
  return all;
}

/// The ways to launch that a test tries, none of which may change a bit: all lane counts, each with another work-group.
/// Every way builds the kernels anew, and all are compared with the same reference.
inline std::vector<DeviceOptions> all_launch_options() { return launch_options({{1, 7}, {8, 4}, {16, 0}}); }

/// Whether to try what is slow and rarely finds more (scripts/test --full).
bool try_all();

/// Steps under CheckedBackend, with poisoned outputs, for every launch option: fails with the first word that differs.
/// Kernels are optimised where users of a CPU have them so: for the usual lanes, in the usual work-group. Others are
/// built in a third of the time as they are, and no bit may depend on that either.
template <class real>
void expect_twins_agree(const InitialState<real>& state, int steps,
                        const std::vector<DeviceOptions>& launches = all_launch_options());

/// Runs one stage from these buffers (as many elements each as `sizes` says; absent ones may be empty) for every launch
/// option, its fully rewritten outputs poisoned. Fails with the first word that differs; returns the reference's
/// buffers after the stage. Kernels are not optimised but by scripts/test --full: the twins of whole steps and the
/// golden scenes are.
template <class real>
Buffers<real> run_one_stage(Stage stage, const Buffers<real>& buffers, const Sizes& sizes, Features features,
                            const StepParams<real>& params,
                            const std::vector<DeviceOptions>& launches = all_launch_options());

}  // namespace lockstep
