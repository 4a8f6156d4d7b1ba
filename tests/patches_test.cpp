// The friction model `patches`: the twins of every stage that knows it, and what it must share with Coulomb's law.
#include <gtest/gtest.h>

#include "host/report/residual.hpp"
#include "tests/patch_scene.hpp"

namespace lockstep::test::patches_test {
namespace {

template <class real>
class Patches : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Patches, Precisions);

TYPED_TEST(Patches, KernelMatchesReference) {
  using real = TypeParam;
  for (const bool soft : {false, true}) {
    InitialState<real> state = patch_pile<real>(soft);
    ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], 300u);
    ASSERT_GT(state.buffers.counters[COUNTER_ROWS], state.buffers.counters[COUNTER_BLOCKS]);
    for (u32 substep = 0; substep < 2; ++substep) {
      state.params.substep = substep;
      for (const Stage stage : {Stage::prepare_contacts, Stage::warm_start, Stage::solve_constraints})
        state.buffers = run_twins(stage, state);
      if (soft) state.buffers = run_twins(Stage::relax_constraints, state);
    }
  }
}

// A block that slides comes to rest where mu g t = v, after v^2 / (2 mu g), and does not turn.
TYPED_TEST(Patches, ASlidingBoxStopsWhereCoulombStopsIt) {
  using real = TypeParam;
  InitialState<real> state = box_on_ground<real>({0.5, 0.4, 0.1}, 0.3);
  const double speed = 2, dt = double(state.params.dt), g = 9.81;
  state.buffers.gravities[0] = {0, 0, real(-g), 0};
  state.buffers.motions[0].v[0] = real(speed * 0.8);
  state.buffers.motions[0].v[1] = real(speed * 0.6);
  const Buffers<real> after = run_steps(state, 60);
  // semi-implicit Euler: the sum of v - k mu g dt over the steps that it still moves
  double distance = 0;
  for (double v = speed - 0.3 * g * dt; v > 0; v -= 0.3 * g * dt) distance += v * dt;
  EXPECT_NEAR(double(after.positions[0].x), 0.8 * distance, 5e-3 * distance);
  EXPECT_NEAR(double(after.positions[0].y), 0.6 * distance, 5e-3 * distance);
  EXPECT_NEAR(double(after.orientations[0].z), 0, 1e-4);
  EXPECT_NEAR(double(after.motions[0].v[0]), 0, 1e-5);
}

// A block that spins on four corners is slowed by mu m g times their moment arm, over its moment of inertia.
TYPED_TEST(Patches, ARotatingBoxIsSlowedByFrictionAtItsCorners) {
  using real = TypeParam;
  InitialState<real> state = box_on_ground<real>({0.4, 0.3, 0.05}, 0.2);
  const double g = 9.81, arm = 0.5, inertia = (0.16 + 0.09) / 3, dt = double(state.params.dt);
  state.buffers.gravities[0] = {0, 0, real(-g), 0};
  state.buffers.motions[0].w[2] = 8;
  const Buffers<real> after = run_steps(state, 20);
  EXPECT_NEAR(double(after.motions[0].w[2]), 8 - 20 * dt * 0.2 * g * arm / inertia, 0.01);
  EXPECT_NEAR(double(after.motions[0].v[0]), 0, 0.02);  // of corners at 4 m/s: their loads are not unique
  const Buffers<real> later = run_steps(state, 60);
  EXPECT_NEAR(double(later.motions[0].w[2]), 0, 1e-5);
}

// On a slope it rests where tan alpha < mu and slides with g (sin alpha - mu cos alpha) where it is larger.
TYPED_TEST(Patches, ABoxSticksAndSlipsOnASlope) {
  using real = TypeParam;
  const double sine = 0.6, cosine = 0.8, g = 9.81;  // tan = 0.75
  for (const double friction : {0.5, 0.74, 0.76}) {
    InitialState<real> state = box_on_ground<real>({0.5, 0.5, 0.1}, friction);
    state.buffers.gravities[0] = {real(-g * sine), 0, real(-g * cosine), 0};
    const Buffers<real> after = run_steps(state, 60);
    const double pull = std::max(0.0, sine - friction * cosine);
    EXPECT_NEAR(double(after.motions[0].v[0]), -g * pull, 0.01 * g * pull + 1e-4) << friction;
  }
}

// Where a box slides without turning, every contact rubs against the same velocity, and a patch is as good as four
// cones. Where it spins too, friction and twist together are more than Coulomb gives: that is the model's error.
TEST(PatchResidual, SeesTheModelErrorOfARotatingBoxOnly) {
  for (const double angular_velocity : {0.0, 8.0}) {
    InitialState<double> state = box_on_ground<double>({0.4, 0.3, 0.05}, 0.2);
    state.buffers.gravities[0] = {0, 0, -9.81, 0};
    state.buffers.motions[0].v[0] = 2;
    state.buffers.motions[0].w[2] = angular_velocity;
    const Buffers<double> after = run_steps(state, 10);
    const Residual r = residual(contact_system(after, after.counters), 0x1p-53);
    EXPECT_LT(r.relative, 1e-6) << angular_velocity;
    ASSERT_TRUE(r.model_error.has_value());
    if (angular_velocity == 0)
      EXPECT_LT(std::abs(*r.model_error), 1e-6);
    else
      EXPECT_GT(*r.model_error, 0.01);
  }
}

// What is given to a is taken from b, wherever it acts.
TYPED_TEST(Patches, ConservesMomentum) {
  using real = TypeParam;
  BodyDescription a = box_body({0, 0, 0.49}, {0.5, 0.5, 0.5}), b = box_body({0.2, 0.1, -0.49}, {0.5, 0.5, 0.5});
  a.velocity = {1, 0.3, -1};
  a.angular_velocity = {0.2, 0.5, 3};
  b.mass = 3;
  b.inertia = {0.5, 0.5, 0.5};
  InitialState<real> state = make_worlds<real>({{a, b}}, 16);
  use_patches(state);
  set_material(state, 0.5, 0);
  state.params.theta = 1;
  state.buffers.gravities[0] = {0, 0, 0, 0};
  run_until_prepared(state);
  ASSERT_EQ(state.buffers.block_bodies[0].count[0], 4u);
  const auto [linear, angular] = momentum(state.buffers);
  reference::run_stage(Stage::solve_constraints, state.buffers, state.params);
  EXPECT_NE(double(state.buffers.patch_impulses[0].twist[0]), 0);
  const auto [linear_after, angular_after] = momentum(state.buffers);
  for (u32 k = 0; k < 3; ++k) {
    EXPECT_NEAR(linear_after[k], linear[k], sizeof(real) == 4 ? 2e-6 : 1e-14);
    EXPECT_NEAR(angular_after[k], angular[k], sizeof(real) == 4 ? 2e-6 : 1e-14);
  }
}

}  // namespace
}  // namespace lockstep::test::patches_test
