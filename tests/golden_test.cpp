// The device computes the golden hashes too, with any lanes, work-groups and threads.
#include "tests/golden/golden.hpp"

#include <fstream>
#include <tuple>

#include "host/backends/device_backend.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::golden_test {
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

// Kernels are optimised as users have them; for other lanes that takes three times as long to build. pocl 3.1 links the
// launch of all sub-steps only if it is optimised.
DeviceOptions options(u32 lanes, u32 work_group, u32 threads, std::optional<SubstepPlan> substeps = {}) {
  DeviceOptions result;
  result.lanes = lanes;
  result.work_group = work_group;
  result.threads = threads;
  result.substeps = substeps;
  result.optimize = lanes == 0 || (substeps && substeps != SubstepPlan::launches) || try_all();
  return result;
}

// The launch that a device chooses, and two others.
const DeviceOptions launches[] = {options(0, 0, 0), options(1, 0, 2, SubstepPlan::one_group),
                                  options(8, 5, 1, SubstepPlan::launches)};

// Which launch, and which shard of the cases: shards run side by side.
class Golden : public testing::TestWithParam<std::tuple<std::size_t, std::size_t>> {};
constexpr std::size_t shards = 6, launch_count = std::size(launches), others = launch_count - 1;

// Every case by the usual launch, every second one by one of the others in turn: each builds the kernels anew, and the
// tests of the stages try all of them.
bool is_tried(std::size_t i, std::size_t launch) { return launch == 0 || i % (2 * others) == 2 * (launch - 1); }

TEST_P(Golden, HashesOfTheDevice) {
  const auto [launch, shard] = GetParam();
  const std::vector<GoldenCase> cases = golden_cases();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (i / (2 * others) % shards != shard || !is_tried(i, launch)) continue;
    const GoldenCase& expected = cases[i];
    GoldenCase found = expected;
    if (expected.precision == "double")
      run_on_device<double>(found, launches[launch]);
    else
      run_on_device<float>(found, launches[launch]);
    SCOPED_TRACE(expected.scene + " in " + expected.precision);
    EXPECT_EQ(found.state_hash, expected.state_hash);
    EXPECT_EQ(found.pose_hash, expected.pose_hash);
  }
}

std::string name_of(const testing::TestParamInfo<Golden::ParamType>& tried) {
  const auto [launch, shard] = tried.param;
  const DeviceOptions& o = launches[launch];
  return "lanes" + std::to_string(o.lanes) + "_work_group" + std::to_string(o.work_group) + "_threads" +
         std::to_string(o.threads) + "_shard" + std::to_string(shard);
}

INSTANTIATE_TEST_SUITE_P(AllLaunches, Golden,
                         testing::Combine(testing::Range(std::size_t{0}, launch_count),
                                          testing::Range(std::size_t{0}, shards)),
                         name_of);

}  // namespace
}  // namespace lockstep::golden_test
