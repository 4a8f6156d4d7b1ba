#include <gtest/gtest.h>

#include "tests/contact_scene.hpp"

namespace lockstep::test::relax_constraints_test {
namespace {

template <class real>
class RelaxConstraints : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(RelaxConstraints, Precisions);

// Contacts of random geometry, two of three of them soft.
template <class real>
InitialState<real> soft_problem(u32 seed, u32 bodies, u32 contacts) {
  InitialState<real> state = random_problem<real>(seed, bodies, contacts);
  state.features = with(state.features, Feature::soft_contacts);
  resize(state.buffers, state.sizes, state.features);
  Random random(seed);
  for (u32 row = 0; row < state.buffers.counters[COUNTER_ROWS]; ++row) {
    for (real& softness : state.buffers.softness_blocks[row].softness)
      softness = random.bits() % 3 != 0 ? real(random.between(0.01, 1)) : real(0);
  }
  return state;
}

TYPED_TEST(RelaxConstraints, KernelMatchesReference) {
  using real = TypeParam;
  for (const Stage stage : {Stage::relax_constraints, Stage::solve_constraints}) {
    for (const u32 relaxations : {1u, 3u}) {
      InitialState<real> small = soft_problem<real>(1, 40, 90), large = soft_problem<real>(2, 900, 3000);
      small.params.relaxations = large.params.relaxations = relaxations;
      run_twins(stage, small);
      run_twins(stage, large);
    }
  }
}

// A ball of 1 kg that overlaps the ground by `depth`, without gravity.
template <class real>
InitialState<real> sunken_ball(double depth) {
  InitialState<real> state = make_worlds<real>({{sphere_body({0, 0, 1 - depth}, 1), plane_body()}}, 16);
  state.features = with(state.features, Feature::soft_contacts);
  resize(state.buffers, state.sizes, state.features);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  state.params.theta = 1;
  state.params.slop = 0;
  state.params.correction = real(0.25);
  state.params.softness = real(0.5);
  return state;
}

// u + bias + softness r = 0 with u = r / m and softness 0.5 / m: the spring gives two thirds of the bias.
TYPED_TEST(RelaxConstraints, SoftContactsYield) {
  using real = TypeParam;
  InitialState<real> state = sunken_ball<real>(0.02);
  run_until_prepared(state);
  Buffers<real>& b = state.buffers;
  EXPECT_NEAR(double(b.contact_blocks[0].bias[0]), -0.25 * 0.02 * 60, 1e-5);
  reference::run_stage(Stage::solve_constraints, b, state.params);
  EXPECT_NEAR(double(b.motions[0].v[2]), 0.3 * 2 / 3, 1e-5);
  // its velocity moves the ball out, and is taken back
  reference::run_stage(Stage::integrate_positions, b, state.params);
  reference::run_stage(Stage::relax_constraints, b, state.params);
  EXPECT_EQ(double(b.motions[0].v[2]), 0);
  EXPECT_NEAR(double(b.positions[0].z), 0.98 + 0.2 / 60, 1e-6);
  EXPECT_EQ(double(b.impulse_blocks[0].normal[0]), 0);
}

// Two balls, one on the other, that springs push apart: the lower is between two contacts, and what a sweep takes back
// at one of them it disturbs at the other. Each sweep leaves a share of the velocity of the one before.
TYPED_TEST(RelaxConstraints, EachSweepLeavesLess) {
  using real = TypeParam;
  InitialState<real> state =
      make_worlds<real>({{sphere_body({0, 0, 0.98}, 1), sphere_body({0, 0, 2.96}, 1), plane_body()}}, 16);
  state.features = with(state.features, Feature::soft_contacts);
  resize(state.buffers, state.sizes, state.features);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  state.params.theta = 1;
  state.params.correction = real(0.25);
  state.params.softness = real(0.05);
  std::vector<double> left;
  for (const u32 relaxations : {1u, 2u, 4u, 8u}) {
    state.params.relaxations = relaxations;
    const Buffers<real> after = run_steps(state, 1);
    left.push_back(std::abs(double(after.motions[0].v[2])) + std::abs(double(after.motions[1].v[2])));
  }
  for (std::size_t i = 1; i < left.size(); ++i) EXPECT_LT(left[i], 0.8 * left[i - 1]);
}

// Depth falls by the same share in each step, and no energy is left.
TYPED_TEST(RelaxConstraints, OverlapDecaysAndLeavesNoVelocity) {
  using real = TypeParam;
  const InitialState<real> state = sunken_ball<real>(0.02);
  const Buffers<real> after = run_steps(state, 10);
  EXPECT_NEAR(1 - double(after.positions[0].z), 0.02 * std::pow(1 - 0.25 * 2 / 3, 10), 1e-6);
  EXPECT_EQ(double(after.motions[0].v[2]), 0);
}

// A contact that bounces keeps what it gave.
TYPED_TEST(RelaxConstraints, BouncesAreKept) {
  using real = TypeParam;
  InitialState<real> state = sunken_ball<real>(0.001);
  set_material(state, 0, 0.5);
  state.buffers.motions[0].v[2] = -2;
  const Buffers<real> after = run_steps(state, 1);
  EXPECT_NEAR(double(after.motions[0].v[2]), 1, 1e-5);
}

TYPED_TEST(RelaxConstraints, AbortedStepsWriteNothing) {
  using real = TypeParam;
  InitialState<real> state = soft_problem<real>(8, 30, 60);
  state.buffers.counters[COUNTER_STATUS] = STATUS_ROWS_FULL;
  const Buffers<real> after = run_twins(Stage::relax_constraints, state);
  for (u32 i = 0; i < 30; ++i) EXPECT_EQ(after.motions[i].v[0], state.buffers.motions[i].v[0]);
}

}  // namespace
}  // namespace lockstep::test::relax_constraints_test
