// Solvers along a gradient: the twins, what a step of the descent promises, and how fast it arrives.
#include <gtest/gtest.h>

#include <cstring>

#include "tests/gradient_scene.hpp"
#include "tests/jacobi_scene.hpp"

namespace lockstep::test::gradient_test {
namespace {

template <class real>
class Gradient : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Gradient, Precisions);

// Small enough for one work-group, and not.
TYPED_TEST(Gradient, KernelMatchesReference) {
  using real = TypeParam;
  for (const bool accelerated : {false, true}) {
    for (const bool large : {false, true}) {
      const InitialState<real> state =
          started_by_gradient(large ? heap<real>(5, 400, 8192) : heap<real>(6, 12, 256), accelerated, large ? 12 : 30);
      ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], large ? 1000u : 20u);
      ASSERT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
      run_twins(Stage::solve_constraints, state);
    }
  }
}

// Balls alone: central contacts, of which each pair has one.
TYPED_TEST(Gradient, CentralKernelMatchesReference) {
  using real = TypeParam;
  std::vector<BodyDescription> bodies = strewn_ball(200);
  InitialState<real> state = make_worlds<real>({bodies}, 1024);
  state.params.theta = 1;
  state = started_by_gradient(state, true, 15);
  for (u32 block = 0; block < state.buffers.counters[COUNTER_BLOCKS]; ++block) {
    for (const u32 kind : state.buffers.block_bodies[block].kind) ASSERT_NE(kind, u32{BLOCK_GENERAL});
  }
  state.features &= ~static_cast<Features>(Feature::general_contacts);
  run_twins(Stage::solve_constraints, state);
}

// Each world chooses its own steps: it has the bits that it has alone.
TYPED_TEST(Gradient, AWorldIsAsItIsAlone) {
  using real = TypeParam;
  for (const double tolerance : {0.0, 0.02}) {
    InitialState<real> together = heaps<real>({20, 60, 100}), alone = heaps<real>({60});
    for (InitialState<real>* state : {&together, &alone}) {
      use_gradient(*state);
      state->params.tolerance = real(tolerance);
      if (tolerance > 0) state->features = with(state->features, Feature::tolerance);
    }
    expect_world_is_as_alone(run_steps(together, 3), 1, run_steps(alone, 3));
    expect_twins_agree(together, 3, launch_options({{1, 7}, {16, 0}}));
  }
}

TYPED_TEST(Gradient, StepsMatchTheReference) {
  using real = TypeParam;
  InitialState<real> state = heap<real>(7, 60, 4096);
  use_gradient(state, true, 20);
  expect_twins_agree(state, 6, launches_of_all_threads_and_one());
}

TYPED_TEST(Gradient, ToleranceMatchesTheReference) {
  using real = TypeParam;
  for (const bool large : {false, true}) {
    for (const double tolerance : {0.3, 1e-9}) {
      InitialState<real> state = started_by_gradient(
          large ? heap<real>(5, 400, 8192, false) : heap<real>(6, 12, 256, false), true, tolerance > 0.1 ? 1000 : 8);
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

TYPED_TEST(Gradient, AbortedStepsWriteNothing) {
  using real = TypeParam;
  InitialState<real> state = started_by_gradient(heap<real>(9, 12, 256), true, 5);
  state.buffers.counters[COUNTER_STATUS] = STATUS_PAIRS_FULL;
  const Buffers<real> after = run_twins(Stage::solve_constraints, state);
  for (u32 i = 0; i < state.params.bodies; ++i)
    EXPECT_EQ(std::memcmp(&after.motions[i], &state.buffers.motions[i], sizeof(Motion<real>)), 0) << i;
}

// What impulses give the bodies adds up: bodies that nothing else pushes keep their momentum.
TYPED_TEST(Gradient, ConservesMomentum) {
  using real = TypeParam;
  InitialState<real> state = balls_that_collide<real>();
  use_gradient(state, true, 300);
  run_until_prepared(state);
  expect_solving_keeps_momentum(state, sizeof(real) == 4 ? 5e-4 : 1e-12);
}

// ---- what a descent promises ---------------------------------------------------------------------------------------

// Ready to be solved from no impulses, so that its velocities are the free ones.
// Nothing in it is held: where bodies are squeezed between some that cannot move no velocity is right, and the
// objective has no least value.
InitialState<double> prepared_by_gradient(bool accelerated) {
  InitialState<double> state = heap<double>(8, 60, 4096, false);
  use_gradient(state, accelerated);
  run_until_prepared(state);
  return state;
}

double objective_after(const InitialState<double>& state, u32 iterations) {
  InitialState<double> solved = state;
  solved.params.iterations = iterations;
  reference::run_stage(Stage::solve_constraints, solved.buffers, solved.params);
  return objective_of(state.buffers, solved.buffers);
}

// Steps that would lead uphill are not taken, however long they have become.
TEST(GradientDescends, WithEachStep) {
  const InitialState<double> state = prepared_by_gradient(false);
  ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], 100u);
  double last = 0, first = 0;
  u32 stayed = 0;
  for (u32 iterations = 1; iterations <= 100; ++iterations) {
    const double current = objective_after(state, iterations);
    EXPECT_LE(current, last + 1e-12 * std::abs(last)) << iterations;
    stayed += current == last;
    if (iterations == 1) first = current;
    last = current;
  }
  EXPECT_LT(first, 0);
  EXPECT_LT(last, 1.1 * first);  // both are negative
  EXPECT_GT(stayed, 0u);         // there were steps that were not taken: this is what they are for
  EXPECT_LT(stayed, 30u);
}

// Momentum does in tens of steps what takes hundreds without.
TEST(GradientDescends, FasterWithMomentum) {
  const double least = objective_after(prepared_by_gradient(true), 20000);
  const InitialState<double> plain = prepared_by_gradient(false), accelerated = prepared_by_gradient(true);
  EXPECT_LT(least, 1.1 * objective_after(plain, 20));  // negative
  const auto left = [&](const InitialState<double>& state, u32 iterations) {
    return (objective_after(state, iterations) - least) / std::abs(least);
  };
  const double after_plain = left(plain, 1000), after_accelerated = left(accelerated, 200);
  EXPECT_GT(after_plain, 0);
  EXPECT_LT(after_accelerated, after_plain) << "of " << least;
  EXPECT_LT(left(accelerated, 1000), 1e-2 * after_plain);
}

// News of its weight has to pass through a column of boxes.
TEST(GradientDescends, AColumnOfBoxes) {
  std::vector<BodyDescription> bodies = {plane_body()};
  for (u32 i = 0; i < 10; ++i) bodies.push_back(box_body({0, 0, 0.5 + i}, {0.5, 0.5, 0.5}));
  InitialState<double> state = make_worlds<double>({bodies}, 64);
  set_material(state, 0.5, 0);
  state.params.theta = 1;
  const auto residual_after = [&](bool accelerated, u32 iterations) {
    InitialState<double> solved = state;
    use_gradient(solved, accelerated, iterations);
    return residual_of(run_steps(solved, 1)).relative;
  };
  const double plain = residual_after(false, 100), accelerated = residual_after(true, 100);
  EXPECT_LT(plain, 0.5);
  EXPECT_LT(accelerated, 1e-2 * plain);
  EXPECT_LT(accelerated, residual_after(false, 500));
}

}  // namespace
}  // namespace lockstep::test::gradient_test
