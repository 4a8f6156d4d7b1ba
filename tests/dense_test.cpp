// Gauss-Seidel by the dense Delassus matrix: the twins, whatever the launches, and that a world is as it is alone.
#include <gtest/gtest.h>

#include <cstring>

#include "host/scene/read.hpp"
#include "tests/dense_scene.hpp"

namespace lockstep::test::dense_test {
namespace {

template <class real>
class Dense : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Dense, Precisions);

// Small enough for one work-group, and not.
TYPED_TEST(Dense, KernelMatchesReference) {
  using real = TypeParam;
  for (const bool large : {false, true}) {
    const InitialState<real> state =
        started_dense(large ? heap<real>(5, 400, 8192) : heap<real>(6, 12, 256), large ? 3 : 10);
    ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], large ? 1024u : 20u);
    ASSERT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
    run_twins(Stage::solve_constraints, state);
  }
}

// A work-group for each of several worlds, some of which have no contacts.
TYPED_TEST(Dense, WorldsMatchTheReference) {
  using real = TypeParam;
  const InitialState<real> state = started_dense(heaps<real>({90, 0, 30, 120, 0, 90, 30}), 3);
  ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], 1024u);
  ASSERT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
  run_twins(Stage::solve_constraints, state);
}

TYPED_TEST(Dense, AWorldIsAsItIsAlone) {
  using real = TypeParam;
  InitialState<real> together = heaps<real>({30, 60, 0, 30}), alone = heaps<real>({60});
  use_dense(together);
  use_dense(alone);
  expect_world_is_as_alone(run_steps(together, 3), 1, run_steps(alone, 3));
  expect_twins_agree(together, 3, launch_options({{1, 7}, {16, 0}}));
}

TYPED_TEST(Dense, StepsMatchTheReference) {
  using real = TypeParam;
  InitialState<real> state = heap<real>(7, 60, 4096);
  use_dense(state, 5);
  expect_twins_agree(state, 6, launches_of_all_threads_and_one());
}

TYPED_TEST(Dense, ToleranceMatchesTheReference) {
  using real = TypeParam;
  for (const bool large : {false, true}) {
    for (const double tolerance : {0.3, 1e-9}) {
      InitialState<real> state = started_dense(large ? heap<real>(5, 400, 8192, false) : heap<real>(6, 12, 256, false),
                                               tolerance > 0.1 ? 100 : 4);
      state.features = with(state.features, Feature::tolerance);
      state.params.tolerance = real(tolerance);
      const Buffers<real> after = run_twins(Stage::solve_constraints, state);
      EXPECT_EQ(after.counters[COUNTER_SWEEPS]<state.params.iterations, tolerance> 0.1)
          << after.counters[COUNTER_SWEEPS];
      EXPECT_EQ(after.counters[COUNTER_SETTLED], 0u);
      EXPECT_EQ(after.counters[COUNTER_UNSOLVED], tolerance > 0.1 ? 0u : 1u);
    }
  }
}

// Joints take turns with the sweeps, and laws of impact have biases along the tangents.
TYPED_TEST(Dense, ScenesMatchTheReference) {
  using real = TypeParam;
  const std::pair<const char*, int> scenes[] = {{"rag_doll", 50}, {"eccentric_impacts", 40}};
  for (const auto& [name, steps] : scenes) {
    SCOPED_TRACE(name);
    Scene scene = read_scene(name);
    replace_solver(scene.settings, Solver::dense_gauss_seidel);
    const InitialState<real> state = compile<real>(scene);
    ASSERT_TRUE(has(state.features, Feature::dense));
    expect_twins_agree(state, steps, launch_options({{1, 7}, {16, 0}}));
  }
}

// Too many of them for one work-group: sweeps by launches, and a tolerance that asks after each.
TYPED_TEST(Dense, ManyDollsMatchTheReference) {
  using real = TypeParam;
  Scene scene = read_scene("rag_doll");
  replace_solver(scene.settings, Solver::dense_gauss_seidel);
  scene.settings.iterations = 4;
  for (BodyDescription& body : scene.bodies) body.velocity[2] -= 8;
  const InitialState<real> state = compile<real>(std::vector<Scene>(120, scene));
  ASSERT_GE(state.buffers.joint_phases[1], LARGE_COLOR);
  expect_twins_agree(state, 20, launch_options({{16, 0}, {1, 7}}));
}

TYPED_TEST(Dense, AbortedStepsWriteNothing) {
  using real = TypeParam;
  for (const u32 status : {u32{STATUS_PAIRS_FULL}, u32{STATUS_COUPLED_TILES_FULL}, u32{STATUS_TOO_DENSE}}) {
    InitialState<real> state = started_dense(heap<real>(9, 12, 256), 5);
    state.buffers.counters[COUNTER_STATUS] = status;
    const Buffers<real> after = run_twins(Stage::solve_constraints, state);
    for (u32 i = 0; i < state.params.bodies; ++i)
      EXPECT_EQ(std::memcmp(&after.motions[i], &state.buffers.motions[i], sizeof(Motion<real>)), 0) << i;
  }
}

}  // namespace
}  // namespace lockstep::test::dense_test
