#include <gtest/gtest.h>

#include <map>

#include "tests/jacobi_scene.hpp"

namespace lockstep::test::split_bodies_test {
namespace {

template <class real>
class SplitBodies : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SplitBodies, Precisions);

// Packed and ready to be split.
template <class real>
InitialState<real> packed(InitialState<real> state) {
  use_jacobi(state);
  reference::run_stage(Stage::pack_contacts, state.buffers, state.params);
  return state;
}

template <class real>
InitialState<real> packed_graphs(u32 seed, u32 bodies, u32 contacts) {
  Random random(seed);
  const auto [kinds, graph] = random_graph(random, bodies, contacts);
  const auto [more_kinds, more] = random_graph(random, 30, 70);
  return packed(
      contact_graphs<real>({kinds, more_kinds}, {with_manifolds(random, graph), with_manifolds(random, more)}));
}

// A hub, dynamic or not, that `count` bodies touch.
template <class real>
InitialState<real> packed_star(u32 count, BodyKind hub) {
  const auto [kinds, graph] = star(count, hub);
  return packed(contact_graphs<real>({kinds}, {graph}));
}

TYPED_TEST(SplitBodies, KernelMatchesReference) {
  using real = TypeParam;
  run_twins(Stage::split_bodies, packed_graphs<real>(1, 40, 90));
  run_twins(Stage::split_bodies, packed_graphs<real>(2, 6000, 20000));
  run_twins(Stage::split_bodies, packed_star<real>(200, BODY_DYNAMIC));
  run_twins(Stage::split_bodies, packed_star<real>(200, BODY_KINEMATIC));
  run_twins(Stage::split_bodies, packed(contact_graphs<real>({{BODY_DYNAMIC, BODY_STATIC}}, {{}})));
}

// Blocks that do not fit are left out, and the rest is as sound.
TYPED_TEST(SplitBodies, KernelMatchesReferenceWhereBlocksAreFull) {
  using real = TypeParam;
  InitialState<real> state = packed_graphs<real>(3, 100, 400);
  state.sizes.blocks = state.params.block_capacity = 4;
  resize(state.buffers, state.sizes, state.features);
  reference::run_stage(Stage::pack_contacts, state.buffers, state.params);
  ASSERT_NE(state.buffers.counters[COUNTER_STATUS] & STATUS_BLOCKS_FULL, 0u);
  run_twins(Stage::split_bodies, state);
}

// A body has as many copies as pairs, one after another in the order of the slots; what cannot move has none.
TYPED_TEST(SplitBodies, EachPairHasItsCopyOfEachBody) {
  using real = TypeParam;
  InitialState<real> state = packed_graphs<real>(4, 60, 300);
  reference::run_stage(Stage::split_bodies, state.buffers, state.params);
  const Buffers<real>& b = state.buffers;
  ASSERT_EQ(b.counters[COUNTER_COLORS], 1u);
  std::map<u32, std::vector<u32>> copy_slots;
  std::map<u32, std::vector<double>> counts;
  u32 pairs = 0;
  for (u32 slot = 0; slot < b.counters[COUNTER_BLOCKS] * PACK; ++slot) {
    const BlockBodies& bodies = b.block_bodies[slot / PACK];
    const BodyCopyBlock<real>& split = b.body_copy_blocks[slot / PACK];
    const u32 lane = slot % PACK;
    pairs += bodies.count[lane] > 0;
    const auto look = [&](u32 body, u32 copy_slot, real count) {
      if (bodies.count[lane] == 0 || b.body_infos[body].kind != BODY_DYNAMIC) {
        EXPECT_EQ(copy_slot, NONE);
        EXPECT_EQ(count, real(0));
        return;
      }
      copy_slots[body].push_back(copy_slot);
      counts[body].push_back(double(count));
    };
    look(bodies.body_a[lane], split.slot_a[lane], split.copies_a[lane]);
    look(bodies.body_b[lane], split.slot_b[lane], split.copies_b[lane]);
  }
  ASSERT_GT(pairs, 200u);
  u32 next = 0;
  for (u32 body = 0; body < state.params.bodies; ++body) {
    EXPECT_EQ(b.body_copy_starts[body], next);
    for (u32 k = 0; k < copy_slots[body].size(); ++k) {
      EXPECT_EQ(copy_slots[body][k], next + k);
      EXPECT_EQ(counts[body][k], double(copy_slots[body].size()));
    }
    next += u32(copy_slots[body].size());
  }
  EXPECT_EQ(b.body_copy_starts[state.params.bodies], next);
}

}  // namespace
}  // namespace lockstep::test::split_bodies_test
