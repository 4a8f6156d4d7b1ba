// All sub-steps as one launch: what the kernel is made of, and that it gives the bits of the stages.
#include "host/device/fused_substeps.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "host/backends/checked_backend.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/step.hpp"
#include "host/world_hash.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::fused_substeps_test {
namespace {

std::size_t occurrences(const std::string& text, const std::string& pattern) {
  std::size_t count = 0;
  for (auto at = text.find(pattern); at != std::string::npos; at = text.find(pattern, at + 1)) ++count;
  return count;
}

TEST(FusedSubsteps, CallTheKernelsOfTheStagesOfASubStep) {
  const InitialState<float> state = compile<float>(read_scene("rag_doll"));
  const KernelSources sources = KernelSources::embedded();
  LaunchPlan plan;
  plan.sizes = state.sizes;
  plan.features = state.features;
  plan.joint_phases = state.buffers.joint_phases;
  plan.counts.iterations = 7;
  plan.small = true;
  const FusedSubsteps fused = fuse_substeps(sources.signatures(stage_files(sources, state.features)), plan);
  EXPECT_TRUE(fused.replaces(Stage::prepare_joints));
  EXPECT_TRUE(fused.replaces(Stage::solve_constraints));
  EXPECT_FALSE(fused.replaces(Stage::collide));
  EXPECT_FALSE(fused.replaces(Stage::store_impulses));
  EXPECT_FALSE(fused.replaces(Stage::integrate_free_flight));  // not of this scene
  EXPECT_EQ(occurrences(fused.text, "    solve_tail("), 1u);
  EXPECT_EQ(occurrences(fused.text, "TEAM_BARRIER("), fused.stages.size());  // one kernel each
  EXPECT_NE(std::ranges::find(fused.values, 7u), fused.values.end());
}

DeviceOptions by(SubstepPlan plan) {
  DeviceOptions options;
  options.substeps = plan;
  return options;
}

// A work-group is too little for many parts of any kind: bodies without a shape count as well.
TEST(FusedSubsteps, AreForSmallScenes) {
  Sizes small;
  small.bodies = small.shapes = small.joints = 512;
  EXPECT_EQ(substep_plan(small, 0, test_device(), {}), SubstepPlan::one_group);
  for (u32 Sizes::*count : {&Sizes::bodies, &Sizes::shapes, &Sizes::joints}) {
    Sizes large = small;
    large.*count = 513;
    EXPECT_EQ(substep_plan(large, 0, test_device(), {}), SubstepPlan::launches);
    EXPECT_EQ(substep_plan(large, 0, test_device(), by(SubstepPlan::one_group)), SubstepPlan::one_group);
  }
}

// Device and reference side by side, with the sub-steps as one launch as well.
template <class real>
void expect_equal_bits(const InitialState<real>& state, int steps, SubstepPlan plan = SubstepPlan::one_group) {
  DeviceOptions options = by(plan);
  if (plan == SubstepPlan::all_groups) options.threads = 2;  // small scenes take one otherwise, and with it one group
  CheckedBackend<real> backend(state, test_device(), options, {.fused = true});
  for (int i = 0; i < steps; ++i) step(backend, state.params);
}

TEST(FusedSubsteps, HaveTheBitsOfTheStages) {
  expect_equal_bits(compile<float>(read_scene("spheres_small")), 40);
  expect_equal_bits(compile<double>(read_scene("rag_doll")), 20);
}

TEST(FusedSubsteps, TakeANumberOfSweepsThatChanges) {
  InitialState<float> state = compile<float>(read_scene("spheres_small"));
  CheckedBackend<float> backend(state, test_device(), by(SubstepPlan::one_group), {.fused = true});
  for (const u32 iterations : {3u, 10u, 1u}) {
    state.params.iterations = iterations;
    for (int i = 0; i < 10; ++i) step(backend, state.params);
  }
}

TEST(FusedSubsteps, TakeANumberOfRelaxingSweepsThatChanges) {
  InitialState<float> state = compile<float>(read_scene("box_stack"));
  CheckedBackend<float> backend(state, test_device(), by(SubstepPlan::one_group), {.fused = true});
  for (const u32 relaxations : {1u, 3u, 2u}) {
    state.params.relaxations = relaxations;
    for (int i = 0; i < 5; ++i) step(backend, state.params);
  }
}

// The stages have a work-group for every 16 bodies, so that only the fused kernel goes wrong.
TEST(FusedSubsteps, AreSeenToDiffer) {
  const InitialState<float> state = compile<float>(read_scene("spheres_small"));
  ASSERT_GT(state.sizes.bodies, 16u);
  DeviceOptions options;
  options.work_group = 16;
  options.substeps = SubstepPlan::one_group;
  options.patches = {{"integrate_velocities.cl", "motions[i] = motion;",
                      "if (get_num_groups(0) == 1u && i == 3u) motion.w[1] = 1.5f;\n    motions[i] = motion;"}};
  CheckedBackend<float> backend(state, test_device(), options, {.fused = true});
  try {
    step(backend, state.params);
    FAIL();
  } catch (const Mismatch& mismatch) {
    EXPECT_EQ(mismatch.difference().stage, Stage::count);
    EXPECT_EQ(std::string(mismatch.what()).find("step 0, all sub-steps as one launch: "), 0u) << mismatch.what();
  }
}

// Work-groups that wait for each other.
TEST(FusedSubsteps, HaveTheBitsOfTheStagesByAllGroups) {
  expect_equal_bits(compile<float>(read_scene("spheres_small")), 40, SubstepPlan::all_groups);
  expect_equal_bits(compile<double>(read_scene("rag_doll")), 20, SubstepPlan::all_groups);
  expect_equal_bits(compile<float>(read_scene("box_stack")), 20, SubstepPlan::all_groups);
}

// One group does not come to the barriers: the others leave, the step is done again by launches, and so are those that
// follow.
TEST(FusedSubsteps, AreLaunchesAgainOnceAGroupDoesNotCome) {
  const InitialState<float> state = compile<float>(read_scene("box_stack"));
  DeviceOptions options = by(SubstepPlan::all_groups);
  options.threads = 2;
  options.patches = {{"team.h", "#define TEAM_PATIENCE 0x40000000u", "#define TEAM_PATIENCE 1000u"},
                     {"team.h", "if (get_local_id(0) == 0) {", "if (get_local_id(0) == 0 && get_group_id(0) == 0) {"}};
  Simulation<float> stalls(std::make_unique<DeviceBackend<float>>(state, test_device(), options), state.params);
  Simulation<float> launches(std::make_unique<DeviceBackend<float>>(state, test_device(), by(SubstepPlan::launches)),
                             state.params);
  for (int i = 0; i < 20; ++i) {
    stalls.step();
    launches.step();
    EXPECT_EQ(state_hash(stalls.world_hashes()[0]), state_hash(launches.world_hashes()[0])) << i;
  }
}

}  // namespace
}  // namespace lockstep::fused_substeps_test
