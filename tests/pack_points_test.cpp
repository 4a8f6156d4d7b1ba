#include <gtest/gtest.h>

#include <cstring>

#include "tests/contact_scene.hpp"

namespace lockstep::test::pack_points_test {
namespace {

template <class real>
class PackPoints : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(PackPoints, Precisions);

// Packed pairs of one to four contacts, whose points, impulses and materials are random.
template <class real>
InitialState<real> random_points(u32 seed, u32 bodies, u32 pairs) {
  InitialState<real> state = random_problem<real>(seed, bodies, pairs);
  Buffers<real>& b = state.buffers;
  Random random(seed);
  const auto fill = [&](auto& records) {
    for (auto& record : records) {
      auto* x = reinterpret_cast<real*>(&record);
      std::generate_n(x, sizeof(record) / sizeof(real), [&] { return real(random.between(-1, 1)); });
    }
  };
  fill(b.contact_points);
  fill(b.start_impulses);
  fill(b.material_pairs);
  for (Contact& contact : b.contacts) contact.normal = random.bits() % 5;
  return state;
}

// The same with a law of impact for the pair, and some contacts that keep cores from passing.
template <class real>
InitialState<real> with_impact_laws(InitialState<real> state) {
  state.features = with(with(state.features, Feature::impact_laws), Feature::continuous);
  resize(state.buffers, state.sizes, state.features);
  state.buffers.impact_pairs.front() = {real(0.25), IMPACT_CHATTERJEE_RUINA, 0};
  for (u32 i = 0; i < state.buffers.counters[COUNTER_CONTACTS]; i += 7)
    state.buffers.contacts[i].feature = CORE_FEATURE;
  return state;
}

TYPED_TEST(PackPoints, KernelMatchesReference) {
  using real = TypeParam;
  run_twins(Stage::pack_points, random_points<real>(1, 40, 90));
  run_twins(Stage::pack_points, random_points<real>(2, 900, 3000));
  run_twins(Stage::pack_points, with_impact_laws(random_points<real>(5, 60, 300)));
}

// Each contact finds its own point, material and impulse in its slot; what is not a contact's is zero.
TYPED_TEST(PackPoints, EachContactIsInItsSlot) {
  using real = TypeParam;
  InitialState<real> state = random_points<real>(3, 60, 300);
  Buffers<real>& b = state.buffers;
  reference::run_stage(Stage::pack_points, b, state.params);
  std::vector<bool> used(b.counters[COUNTER_ROWS] * PACK);
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    const u32 row = b.contact_slots[i] / PACK, lane = b.contact_slots[i] % PACK;
    used[b.contact_slots[i]] = true;
    const PointBlock<real>& p = b.point_blocks[row];
    EXPECT_EQ(p.anchor_a_y[lane], b.contact_points[i].anchor_a[1]);
    EXPECT_EQ(p.anchor_b_z[lane], b.contact_points[i].anchor_b[2]);
    EXPECT_EQ(p.radius_b[lane], b.contact_points[i].radius_b);
    EXPECT_EQ(p.normal_x[lane], b.contact_points[i].normal[0]);
    EXPECT_EQ(p.frame[lane], b.contacts[i].normal);
    EXPECT_EQ(p.friction[lane], b.material_pairs.front().friction);
    EXPECT_EQ(p.restitution[lane], b.material_pairs.front().restitution);
    EXPECT_EQ(b.start_blocks[row].normal[lane], b.start_impulses[i].normal);
    EXPECT_EQ(b.start_blocks[row].tangent_z[lane], b.start_impulses[i].tangent_z);
  }
  for (u32 slot = 0; slot < used.size(); ++slot) {
    if (used[slot]) continue;
    EXPECT_EQ(b.point_blocks[slot / PACK].friction[slot % PACK], 0);
    EXPECT_EQ(b.start_blocks[slot / PACK].normal[slot % PACK], 0);
  }
}

// What keeps the middle of a fast body from passing does not bounce.
TYPED_TEST(PackPoints, CoresDoNotBounce) {
  using real = TypeParam;
  InitialState<real> state = random_points<real>(4, 10, 20);
  Buffers<real>& b = state.buffers;
  b.material_pairs.front().restitution = 1;
  b.contacts[0].feature = CORE_FEATURE;
  reference::run_stage(Stage::pack_points, b, state.params);
  EXPECT_EQ(b.point_blocks[b.contact_slots[0] / PACK].restitution[b.contact_slots[0] % PACK], 0);
  EXPECT_EQ(b.point_blocks[b.contact_slots[1] / PACK].restitution[b.contact_slots[1] % PACK], 1);
}

TYPED_TEST(PackPoints, ContactsHaveTheLawOfTheirMaterials) {
  using real = TypeParam;
  InitialState<real> state = with_impact_laws(random_points<real>(6, 10, 20));
  Buffers<real>& b = state.buffers;
  reference::run_stage(Stage::pack_points, b, state.params);
  for (u32 i = 0; i < 2; ++i) {  // the first is a core's
    const ImpactBlock<real>& impacts = b.impact_blocks[b.contact_slots[i] / PACK];
    const u32 lane = b.contact_slots[i] % PACK;
    EXPECT_EQ(impacts.law[lane], i == 0 ? u32{IMPACT_NEWTON} : u32{IMPACT_CHATTERJEE_RUINA});
    EXPECT_EQ(impacts.tangential_restitution[lane], i == 0 ? real(0) : real(0.25));
  }
}

}  // namespace
}  // namespace lockstep::test::pack_points_test
