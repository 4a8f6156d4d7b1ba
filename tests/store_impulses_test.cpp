#include <gtest/gtest.h>

#include <cmath>

#include "tests/contact_scene.hpp"

namespace lockstep::test::store_impulses_test {
namespace {

template <class real>
class StoreImpulses : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(StoreImpulses, Precisions);

TYPED_TEST(StoreImpulses, KernelMatchesReference) {
  using real = TypeParam;
  run_twins(Stage::store_impulses, random_problem<real>(1, 300, 1500));
  run_twins(Stage::store_impulses, star_problem<real>(100));
}

// The vector in the world has the length that the two parts had, lies in the tangent plane, and the key names the
// contact.
TYPED_TEST(StoreImpulses, KeepsTheImpulseAsAVectorOfTheWorld) {
  using real = TypeParam;
  InitialState<real> state = random_problem<real>(3, 100, 400);
  Buffers<real>& b = state.buffers;
  const u32 count = b.counters[COUNTER_CONTACTS];
  for (u32 i = 0; i < count; ++i) b.contacts[i].feature = 7 * i;
  reference::run_stage(Stage::store_impulses, b, state.params);
  ASSERT_EQ(b.cached_count[0], count);
  const double tolerance = sizeof(real) == 4 ? 1e-6 : 1e-14;
  for (u32 i = 0; i < count; ++i) {
    const u32 block = b.contact_slots[i] / PACK, lane = b.contact_slots[i] % PACK;
    const ContactBlock<real>& c = b.contact_blocks[block];
    const ImpulseBlock<real>& r = b.impulse_blocks[block];
    const ContactImpulse<real>& kept = b.cached_impulses[i];
    EXPECT_EQ(kept.normal, r.normal[lane]);
    EXPECT_NEAR(std::hypot(kept.tangent_x, kept.tangent_y, kept.tangent_z),
                std::hypot(r.tangent_1[lane], r.tangent_2[lane]), tolerance);
    EXPECT_NEAR(double(kept.tangent_x * c.normal_x[lane] + kept.tangent_y * c.normal_y[lane] +
                       kept.tangent_z * c.normal_z[lane]),
                0, tolerance);
    EXPECT_EQ(b.cached_keys[i].shape_a, b.contacts[i].shape_a);
    EXPECT_EQ(b.cached_keys[i].shape_b, b.contacts[i].shape_b);
    EXPECT_EQ(b.cached_keys[i].feature, 7 * i);
    EXPECT_EQ(b.cached_keys[i].normal, 0u);
  }
}

// What is stored is what the next step's warm start gives to the bodies.
TYPED_TEST(StoreImpulses, ComesBackThroughMatchAndPrepare) {
  using real = TypeParam;
  InitialState<real> state = pair_of_spheres<real>();
  Buffers<real>& b = state.buffers;
  b.impulse_blocks[0].normal[0] = 5;
  b.impulse_blocks[0].tangent_1[0] = real(0.8);
  b.impulse_blocks[0].tangent_2[0] = real(-1.1);
  for (Stage stage : {Stage::store_impulses, Stage::match_contacts, Stage::pack_points, Stage::prepare_contacts})
    reference::run_stage(stage, b, state.params);
  EXPECT_EQ(b.impulse_blocks[0].normal[0], 5);
  EXPECT_NEAR(double(b.impulse_blocks[0].tangent_1[0]), 0.8, 1e-6);
  EXPECT_NEAR(double(b.impulse_blocks[0].tangent_2[0]), -1.1, 1e-6);
}

TYPED_TEST(StoreImpulses, AbortedStepsKeepTheCache) {
  using real = TypeParam;
  InitialState<real> state = pair_of_spheres<real>();
  state.buffers.cached_count[0] = 9;
  state.buffers.counters[COUNTER_STATUS] = STATUS_BLOCKS_FULL;
  EXPECT_EQ(run_twins(Stage::store_impulses, state).cached_count[0], 9u);
}

}  // namespace
}  // namespace lockstep::test::store_impulses_test
