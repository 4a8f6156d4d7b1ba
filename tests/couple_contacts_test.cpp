// Tiles of contacts, and which of them share a movable body: the twins, and the lists against their definition.
#include <gtest/gtest.h>

#include "tests/dense_scene.hpp"

namespace lockstep::test::couple_contacts_test {
namespace {

template <class real>
class CoupleContacts : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CoupleContacts, Precisions);

template <class real>
bool share_a_movable_body(const Buffers<real>& b, u32 i, u32 j) {
  for (const u32 body : {b.contacts[i].body_a, b.contacts[i].body_b}) {
    const bool shared = body == b.contacts[j].body_a || body == b.contacts[j].body_b;
    if (shared && b.body_infos[body].kind == BODY_DYNAMIC) return true;
  }
  return false;
}

// Each contact has one slot, each tile one world, and a pair is listed where some of its contacts share a body, and
// nowhere else.
template <class real>
void expect_definition(const Buffers<real>& b) {
  const u32 contacts = b.counters[COUNTER_CONTACTS];
  std::vector<u32> tile_of(contacts, NONE);
  for (u32 tile = 0; tile < b.contact_tiles.size(); ++tile) {
    const auto [first, count] = b.contact_tiles[tile];
    ASSERT_LE(count, PACK);
    for (u32 i = first; i < first + count; ++i) {
      ASSERT_EQ(tile_of[i], NONE);
      tile_of[i] = tile;
      EXPECT_EQ(b.contacts[i].world, b.contacts[first].world);
    }
  }
  std::vector<std::vector<bool>> wanted(b.contact_tiles.size(), std::vector<bool>(b.contact_tiles.size()));
  for (u32 i = 0; i < contacts; ++i) {
    ASSERT_NE(tile_of[i], NONE);
    for (u32 j = 0; j < contacts; ++j)
      if (share_a_movable_body(b, i, j)) wanted[tile_of[i]][tile_of[j]] = true;
  }
  u32 pair = 0;
  for (u32 column = 0; column < b.contact_tiles.size(); ++column) {
    EXPECT_EQ(b.tile_starts[column], pair);
    for (u32 row = 0; row < b.contact_tiles.size(); ++row) {
      if (!wanted[column][row]) continue;
      EXPECT_EQ(b.coupled_tiles[pair].row, row);
      EXPECT_EQ(b.coupled_tiles[pair].column, column);
      ++pair;
    }
  }
  EXPECT_EQ(b.tile_starts.back(), pair);
  EXPECT_EQ(b.counters[COUNTER_COUPLED_TILES_NEEDED], pair);
}

TYPED_TEST(CoupleContacts, KernelMatchesReference) {
  using real = TypeParam;
  for (InitialState<real> state : {heap<real>(5, 200, 4096), heaps<real>({60, 0, 30, 90, 0})}) {
    use_dense(state);
    run_until_prepared(state);
    ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], 200u);
    const Buffers<real> after = run_twins(Stage::couple_contacts, state);
    EXPECT_EQ(after.counters[COUNTER_STATUS], 0u);
    expect_definition(after);
  }
}

// A list that is too short is not written beyond its end, and the step is told.
TYPED_TEST(CoupleContacts, AShortListIsTold) {
  using real = TypeParam;
  InitialState<real> state = heap<real>(5, 100, 2048);
  use_dense(state);
  run_until_prepared(state);
  const u32 needed = state.buffers.counters[COUNTER_COUPLED_TILES_NEEDED];
  ASSERT_GT(needed, 20u);
  state.sizes.coupled_tiles = 20;
  const Buffers<real> after = run_twins(Stage::couple_contacts, state);
  EXPECT_EQ(after.counters[COUNTER_STATUS], u32{STATUS_COUPLED_TILES_FULL});
  EXPECT_EQ(after.counters[COUNTER_COUPLED_TILES_NEEDED], needed);
}

// More contacts of a world than its matrix is for: the body is named, and no tile is where another world's is.
TYPED_TEST(CoupleContacts, AWorldThatIsTooDenseIsTold) {
  using real = TypeParam;
  const auto [few, small_graph] = star(40);
  const auto [many, large_graph] = star(DENSE_CONTACTS + 20);
  InitialState<real> state = contact_graphs<real>({few, many, few}, {small_graph, large_graph, small_graph});
  use_dense(state);
  state.sizes.coupled_tiles = DENSE_CONTACTS / PACK * (DENSE_CONTACTS / PACK) + 100;
  const Buffers<real> after = run_twins(Stage::couple_contacts, state);
  EXPECT_EQ(after.counters[COUNTER_STATUS], u32{STATUS_TOO_DENSE});
  EXPECT_EQ(NONE - after.counters[COUNTER_BAD_BODY], 41 + DENSE_CONTACTS + 1);  // the first that is one too many
  u32 in_tiles = 0;
  for (const ContactTile& tile : after.contact_tiles) in_tiles += tile.count;
  EXPECT_EQ(in_tiles, DENSE_CONTACTS + 80);
}

}  // namespace
}  // namespace lockstep::test::couple_contacts_test
