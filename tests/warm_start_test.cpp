#include <gtest/gtest.h>

#include "tests/contact_scene.hpp"

namespace lockstep::test::warm_start_test {
namespace {

template <class real>
class WarmStart : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(WarmStart, Precisions);

// A packed problem of random geometry (tests/contact_scene.hpp): what is conserved does not depend on it.
TYPED_TEST(WarmStart, KernelMatchesReference) {
  using real = TypeParam;
  run_twins(Stage::warm_start, random_problem<real>(1, 40, 90));
  run_twins(Stage::warm_start, random_problem<real>(2, 400, 2500));
  run_twins(Stage::warm_start, star_problem<real>(200));
}

TYPED_TEST(WarmStart, GivesImpulsesToBothBodies) {
  using real = TypeParam;
  // a unit sphere on the ground: normal 3 N s up, friction along the tangents of z: x and y
  InitialState<real> state = make_worlds<real>({{sphere_body({0, 0, 1}, 1, {0, 0, -1}), plane_body()}}, 16);
  run_until_prepared(state);
  Buffers<real>& b = state.buffers;
  b.motions[0].v[2] = -1;
  b.impulse_blocks[0].normal[0] = 3;
  b.impulse_blocks[0].tangent_1[0] = 1;
  reference::run_stage(Stage::warm_start, b, state.params);
  EXPECT_NEAR(double(b.motions[0].v[2]), 2, 1e-6);
  EXPECT_NEAR(double(b.motions[0].v[0]), 1, 1e-6);
  EXPECT_NEAR(double(b.motions[0].w[1]), -1 / 0.4, 1e-6);  // arm -z, impulse x: moment -y
  for (const real x : b.motions[1].v) EXPECT_EQ(x, 0);
  for (const real x : b.motions[1].w) EXPECT_EQ(x, 0);
}

TYPED_TEST(WarmStart, ConservesMomentum) {
  using real = TypeParam;
  InitialState<real> state = pair_of_spheres<real>();
  const auto [linear, angular] = momentum(state.buffers);
  Buffers<real>& b = state.buffers;
  b.impulse_blocks[0].normal[0] = 2;
  b.impulse_blocks[0].tangent_1[0] = real(0.3);
  b.impulse_blocks[0].tangent_2[0] = real(-0.7);
  reference::run_stage(Stage::warm_start, b, state.params);
  const auto [linear_after, angular_after] = momentum(b);
  const double tolerance = sizeof(real) == 4 ? 1e-6 : 1e-14;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(linear_after[k], linear[k], tolerance);
    EXPECT_NEAR(angular_after[k], angular[k], 5 * tolerance);
  }
}

TYPED_TEST(WarmStart, AbortedStepsWriteNothing) {
  using real = TypeParam;
  InitialState<real> state = pair_of_spheres<real>();
  state.buffers.impulse_blocks[0].normal[0] = 2;
  state.buffers.counters[COUNTER_STATUS] = STATUS_CONTACTS_FULL;
  const Motion<real> before = state.buffers.motions[0];
  reference::run_stage(Stage::warm_start, state.buffers, state.params);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(state.buffers.motions[0].v[k], before.v[k]);
}

}  // namespace
}  // namespace lockstep::test::warm_start_test
