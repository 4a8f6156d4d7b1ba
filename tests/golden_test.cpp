// The device computes the golden hashes too, with any lanes, work-groups and threads.
#include "tests/golden/golden.hpp"

#include <fstream>

#include "host/backends/device_backend.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep {
namespace {

std::vector<GoldenCase> golden_cases() {
  return nlohmann::json::parse(std::ifstream(LOCKSTEP_SOURCE_DIR "/tests/golden/hashes.json"));
}

template <class real>
void run_on_device(GoldenCase& golden, const DeviceOptions& options) {
  run_case<real>(golden, [&](const InitialState<real>& state) {
    return std::make_unique<DeviceBackend<real>>(state, test_device(), options);
  });
}

class Golden : public testing::TestWithParam<DeviceOptions> {};

TEST_P(Golden, HashesOfTheDevice) {
  for (const GoldenCase& expected : golden_cases()) {
    GoldenCase found = expected;
    if (expected.precision == "double")
      run_on_device<double>(found, GetParam());
    else
      run_on_device<float>(found, GetParam());
    SCOPED_TRACE(expected.scene + " in " + expected.precision);
    EXPECT_EQ(found.state_hash, expected.state_hash);
    EXPECT_EQ(found.pose_hash, expected.pose_hash);
  }
}

DeviceOptions options(u32 lanes, u32 work_group, u32 threads) {
  DeviceOptions result;
  result.lanes = lanes;
  result.work_group = work_group;
  result.threads = threads;
  return result;
}

INSTANTIATE_TEST_SUITE_P(AllLaunches, Golden,
                         testing::Values(options(0, 0, 0), options(1, 0, 0), options(8, 5, 0), options(16, 64, 1)),
                         [](const testing::TestParamInfo<DeviceOptions>& launch) {
                           const DeviceOptions& o = launch.param;
                           return "lanes" + std::to_string(o.lanes) + "_work_group" + std::to_string(o.work_group) +
                                  "_threads" + std::to_string(o.threads);
                         });

}  // namespace
}  // namespace lockstep
