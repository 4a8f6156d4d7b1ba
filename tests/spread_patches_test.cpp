#include <gtest/gtest.h>

#include "tests/patch_scene.hpp"

namespace lockstep::test::spread_patches_test {
namespace {

template <class real>
class SpreadPatches : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SpreadPatches, Precisions);

TYPED_TEST(SpreadPatches, KernelMatchesReference) {
  using real = TypeParam;
  InitialState<real> state = patch_pile<real>(false);
  for (const Stage stage : {Stage::prepare_contacts, Stage::solve_constraints})
    reference::run_stage(stage, state.buffers, state.params);
  run_twins(Stage::spread_patches, state);
}

// The contacts of a pair together push and turn as the patch did, and none is beyond its share of either.
TYPED_TEST(SpreadPatches, KeepsTheSumAndTheMoment) {
  using real = TypeParam;
  InitialState<real> state = box_on_ground<real>({0.4, 0.3, 0.1}, 0.5);
  run_until_prepared(state);
  Buffers<real>& b = state.buffers;
  ASSERT_EQ(b.block_bodies[0].count[0], 4u);
  for (u32 k = 0; k < 4; ++k) b.impulse_blocks[k].normal[0] = 2;
  b.patch_impulses[0].tangent_1[0] = 1;
  b.patch_impulses[0].tangent_2[0] = -3;
  b.patch_impulses[0].twist[0] = real(0.7);
  reference::run_stage(Stage::spread_patches, b, state.params);
  double sum[2] = {0, 0}, moment = 0;
  for (u32 k = 0; k < 4; ++k) {  // the normal is z, and its tangents are x and y
    const double x = double(b.contact_blocks[k].arm_a_x[0]), y = double(b.contact_blocks[k].arm_a_y[0]);
    const double t1 = double(b.impulse_blocks[k].tangent_1[0]), t2 = double(b.impulse_blocks[k].tangent_2[0]);
    EXPECT_NEAR(std::hypot(t1 - 0.25, t2 + 0.75), 0.7 / 4 / 0.5, 1e-6);  // a quarter of the moment over the arm
    sum[0] += t1;
    sum[1] += t2;
    moment += x * t2 - y * t1;
  }
  EXPECT_NEAR(sum[0], 1, 1e-6);
  EXPECT_NEAR(sum[1], -3, 1e-6);
  EXPECT_NEAR(moment, 0.7, 1e-6);
}

}  // namespace
}  // namespace lockstep::test::spread_patches_test
