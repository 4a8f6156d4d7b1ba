// Jacobi's method with mass splitting: the twins of every stage that knows it, and what it must share with the sweeps
// over colours: momentum, rest, and where it converges to.
#include <gtest/gtest.h>

#include "host/scene/read.hpp"
#include "tests/jacobi_scene.hpp"

namespace lockstep::test::jacobi_test {
namespace {

template <class real>
class Jacobi : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Jacobi, Precisions);

// Small enough for one work-group, and not; cones, and patches.
TYPED_TEST(Jacobi, KernelMatchesReference) {
  using real = TypeParam;
  for (const bool large : {false, true}) {
    InitialState<real> state = large ? prepared_heap<real>(5, 400, 8192, true) : prepared_heap<real>(6, 12, 256, false);
    ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], large ? 1000u : 20u);
    ASSERT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
    for (const Stage stage :
         {Stage::pack_contacts, Stage::prepare_contacts, Stage::warm_start, Stage::solve_constraints})
      state.buffers = run_twins(stage, state);
  }
}

// Whole steps, in which nothing may depend on lanes, work-groups or threads.
TYPED_TEST(Jacobi, StepsMatchTheReference) {
  using real = TypeParam;
  InitialState<real> state = heap<real>(7, 60, 4096);
  use_jacobi(state);
  expect_twins_agree(state, 8, launches_of_all_threads_and_one());
}

TYPED_TEST(Jacobi, JointsMatchTheReference) {
  using real = TypeParam;
  Scene scene = read_scene("rag_doll");
  replace_solver(scene.settings, Solver::jacobi);
  const InitialState<real> state = compile<real>(scene);
  ASSERT_TRUE(has(state.features, Feature::jacobi));
  EXPECT_FALSE(runs(Stage::color_contacts, state.features));
  EXPECT_FALSE(runs(Stage::relax_constraints, state.features));
  expect_twins_agree(state, 60, launch_options({{16, 7}}));
}

// What one pair takes from a body the others see only after the mean, and what all of them do adds up.
TYPED_TEST(Jacobi, ConservesMomentum) {
  using real = TypeParam;
  InitialState<real> state = balls_that_collide<real>();
  use_jacobi(state);
  run_until_prepared(state);
  expect_solving_keeps_momentum(state, sizeof(real) == 4 ? 1e-4 : 2e-13);
}

// A body with one pair has one copy: the first solve is exact.
TYPED_TEST(Jacobi, ABallRests) {
  using real = TypeParam;
  InitialState<real> state = make_worlds<real>({{sphere_body({0, 0, 1}, 1), plane_body()}}, 16);
  use_jacobi(state);
  state.params.theta = 1;
  state.params.iterations = 1;
  const Buffers<real> after = run_steps(state, 100);
  EXPECT_NEAR(double(after.motions[0].v[2]), 0, sizeof(real) == 4 ? 1e-6 : 1e-14);
  EXPECT_NEAR(double(after.cached_impulses[0].normal), 9.81 / 60, sizeof(real) == 4 ? 1e-6 : 1e-14);
}

// Each ball of a column carries what is above it, m g dt, as with Gauss-Seidel.
TYPED_TEST(Jacobi, AColumnOfBallsBearsItsWeight) {
  using real = TypeParam;
  InitialState<real> state = column_of_balls<real>(6);
  use_jacobi(state);
  state.params.iterations = 2000;
  expect_column_bears_its_weight(run_steps(state, 1), 6, sizeof(real) == 4 ? 1e-4 : 1e-10);
}

// Without friction the velocities at the end are unique, however many contacts share a load.
TEST(JacobiConverges, WhereGaussSeidelDoes) {
  InitialState<double> sweeps = heap<double>(8, 40, 2048);
  set_material(sweeps, 0, 0);
  InitialState<double> jacobi = sweeps;
  use_jacobi(jacobi);
  run_until_prepared(sweeps);
  run_until_prepared(jacobi);
  sweeps.params.iterations = 20000;
  jacobi.params.iterations = 60000;
  expect_both_converge_alike(sweeps, jacobi);
}

// No number of pairs is too many for a body: 200 balls that fly at the surface of a large one.
TYPED_TEST(Jacobi, ABodyHasAnyNumberOfContacts) {
  using real = TypeParam;
  const u32 count = 200;
  std::vector<BodyDescription> bodies = strewn_ball(count);
  for (u32 i = 1; i < bodies.size(); ++i) bodies[i].velocity[2] = -2;
  InitialState<real> state = make_worlds<real>({bodies}, 1024);
  use_jacobi(state);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  state.params.theta = 1;
  state.params.iterations = 300;
  const Buffers<real> after = run_steps(state, 1);
  EXPECT_EQ(after.counters[COUNTER_OVERFLOW], 0u);
  EXPECT_EQ(after.counters[COUNTER_COLORS], 1u);
  ASSERT_EQ(after.counters[COUNTER_CONTACTS], count);
  EXPECT_LT(double(after.motions[0].v[2]), -0.05);
  expect_all_are_stopped(bodies, after);
}

TYPED_TEST(Jacobi, AbortedStepsWriteNothing) {
  using real = TypeParam;
  InitialState<real> state = prepared_heap<real>(9, 12, 256, false);
  state.buffers.counters[COUNTER_STATUS] = STATUS_PAIRS_FULL;
  for (const Stage stage : {Stage::warm_start, Stage::solve_constraints}) {
    const Buffers<real> after = run_twins(stage, state);
    for (u32 i = 0; i < state.params.bodies; ++i) {
      for (u32 k = 0; k < 3; ++k) EXPECT_EQ(after.motions[i].v[k], state.buffers.motions[i].v[k]);
    }
  }
}

}  // namespace
}  // namespace lockstep::test::jacobi_test
