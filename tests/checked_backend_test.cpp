// The comparison of device and reference: it passes where they agree, and names the first word where they do not.
#include "host/backends/checked_backend.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "host/scene/read.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::checked_backend_test {
namespace {

const InitialState<float>& small_pile() {
  static const InitialState<float> state = compile<float>(read_scene("spheres_small"));
  return state;
}

struct Found {
  Difference difference;
  std::string message;
};

// What stepping under these patches finds; nothing where device and reference agree.
std::optional<Found> find_mismatch(const std::vector<KernelPatch>& patches, int steps, bool poison = false) {
  DeviceOptions options;
  options.patches = patches;
  CheckedBackend<float> backend(small_pile(), test_device(), options, {.poison = poison});
  try {
    for (int i = 0; i < steps; ++i) step(backend, small_pile().params);
  } catch (const Mismatch& mismatch) {
    EXPECT_EQ(mismatch.failure(), Failure::comparison);
    return Found{mismatch.difference(), mismatch.what()};
  }
  EXPECT_GT(backend.words_compared(), 0u);
  return std::nullopt;
}

TEST(CheckedBackend, FindsNothingWhereTheTwinsAgree) { EXPECT_FALSE(find_mismatch({}, 40, true)); }

TEST(CheckedBackend, NamesAPlantedFma) {
  const KernelPatch fused = {"integrate_velocities.cl", "v = add3(v, scale3(params.dt, pull));",
                             "v.z = fma(params.dt, pull.z, v.z);"};
  const auto found = find_mismatch({fused}, 40);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->difference.stage, Stage::integrate_velocities);
  EXPECT_EQ(found->difference.buffer, Buffer::motions);
  EXPECT_EQ(found->difference.word, 2u);  // v[2]
  EXPECT_GT(found->difference.step, 0u);  // the first step starts from zero, where fma rounds alike
  const std::string where = "step " + std::to_string(found->difference.step) + ", integrate_velocities: motions[" +
                            std::to_string(found->difference.element) + "] word 2: device 0x";
  EXPECT_EQ(found->message.find(where), 0u) << found->message;
  EXPECT_NE(found->message.find(", reference 0x"), std::string::npos) << found->message;
}

TEST(CheckedBackend, NamesTheWordAndBothValues) {
  const KernelPatch wrong = {"integrate_velocities.cl", "motions[i] = motion;",
                             "if (i == 3u) motion.w[1] = 1.5f;\n    motions[i] = motion;"};
  const auto found = find_mismatch({wrong}, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->message,
            "step 0, integrate_velocities: motions[3] word 5: device 0x3fc00000 (1.5), reference 0x00000000 (0)");
}

TEST(CheckedBackend, NamesAnIntegerWord) {
  const KernelPatch wrong = {"begin_step.cl", "counters[i] = 0u;", "counters[i] = i == 9u ? 7u : 0u;"};
  const auto found = find_mismatch({wrong}, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->message, "step 0, begin_step: counters[9] word 0: device 0x00000007 (7), reference 0x00000000 (0)");
}

TEST(CheckedBackend, PoisonShowsAWordThatAStageLeavesOut) {
  const KernelPatch leaves_out = {"integrate_velocities.cl", "previous_velocities[i] = make_velocity(v, w);",
                                  "if (i != 2u) previous_velocities[i] = make_velocity(v, w);"};
  EXPECT_FALSE(find_mismatch({leaves_out}, 1)) << "all is at rest: what was there before happens to be right";
  const auto found = find_mismatch({leaves_out}, 1, true);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->difference.buffer, Buffer::previous_velocities);
  EXPECT_EQ(found->difference.element, 2u);
  EXPECT_EQ(found->difference.device_value.substr(0, 10), "0xa5a5a5a5");
}

TEST(CheckedBackend, TwinsAgreeHoweverTheStepIsLaunched) {
  std::vector<DeviceOptions> launches = all_launch_options();
  DeviceOptions one_thread;
  one_thread.threads = 1;
  launches.push_back(one_thread);
  expect_twins_agree(small_pile(), 30, launches);
}

TEST(CheckedBackend, TwinsAgreeInDouble) {
  expect_twins_agree(compile<double>(read_scene("spheres_small")), 30, {DeviceOptions()});
}

}  // namespace
}  // namespace lockstep::checked_backend_test
