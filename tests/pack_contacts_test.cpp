#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "tests/contact_scene.hpp"

namespace lockstep::test::pack_contacts_test {
namespace {

template <class real>
class PackContacts : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(PackContacts, Precisions);

// Pairs with random colours, `overflow` of them with none: packing does not ask whether they may share one.
template <class real>
InitialState<real> colored_pairs(u32 seed, u32 pairs, u32 colors, u32 overflow) {
  Random random(seed);
  const auto [kinds, graph] = random_graph(random, 100, pairs);
  InitialState<real> state = contact_graphs<real>({kinds}, {with_manifolds(random, graph)});
  Buffers<real>& b = state.buffers;
  std::vector<u32> firsts;
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    const bool first = reference::pair_contact_count(b, i) > 0;
    b.contact_colors[i] = first ? random.bits() % colors : COLOR_OF_FIRST;
    if (first) firsts.push_back(i);
  }
  for (u32 i = 0; i < overflow; ++i) b.contact_colors[firsts[random.bits() % firsts.size()]] = MAX_COLORS;
  return state;
}

// The slots of each colour hold its pairs by falling number of points, then in order of the list, from the start of a
// block on; an overflow block holds one in its first lane; every other lane is padding. A block has as many rows as the
// largest of its pairs has points, and rows follow one another.
template <class real>
void expect_packed(const Buffers<real>& b, u32 null_body) {
  const u32 blocks = b.counters[COUNTER_BLOCKS];
  ASSERT_EQ(b.color_starts[0], 0u);
  ASSERT_EQ(b.color_starts[MAX_COLORS + 1], blocks);
  std::vector<u32> expected(blocks * PACK, NONE);
  u32 block = 0, used_colors = 0, large_colors = 0, overflow = 0;
  for (u32 color = 0; color <= MAX_COLORS; ++color) {
    ASSERT_EQ(b.color_starts[color], block);
    std::vector<u32> pairs;
    for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
      if (b.contact_colors[i] == color) pairs.push_back(i);
    }
    std::ranges::stable_sort(pairs, std::greater(), [&](u32 i) { return reference::pair_contact_count(b, i); });
    u32 slot = block * PACK;
    for (const u32 i : pairs) {
      ASSERT_LT(slot, expected.size());
      expected[slot] = i;
      slot += color == MAX_COLORS ? PACK : 1;
      if (color == MAX_COLORS) ++overflow;
    }
    const u32 size = (slot + PACK - 1) / PACK - block;
    block += size;
    if (color < MAX_COLORS && size > 0) used_colors = color + 1;
    if (color < MAX_COLORS && size >= LARGE_COLOR) large_colors = color + 1;
  }
  EXPECT_EQ(block, blocks);
  EXPECT_EQ(b.counters[COUNTER_BLOCKS_NEEDED], blocks);
  EXPECT_EQ(b.counters[COUNTER_COLORS], used_colors);
  EXPECT_EQ(b.counters[COUNTER_LARGE_COLORS], large_colors);
  EXPECT_EQ(b.counters[COUNTER_OVERFLOW], overflow);
  u32 rows = 0;
  for (block = 0; block < blocks; ++block) {
    const BlockBodies& bodies = b.block_bodies[block];
    u32 most = 0;
    for (u32 lane = 0; lane < PACK; ++lane) {
      const u32 i = expected[block * PACK + lane];
      ASSERT_EQ(bodies.contact[lane], i);
      const u32 count = i == NONE ? 0 : reference::pair_contact_count(b, i);
      most = std::max(most, count);
      EXPECT_EQ(bodies.count[lane], count);
      EXPECT_EQ(bodies.body_a[lane], i == NONE ? null_body : b.contacts[i].body_a);
      EXPECT_EQ(bodies.body_b[lane], i == NONE ? null_body : b.contacts[i].body_b);
      EXPECT_EQ(bodies.kind[lane] == BLOCK_PADDING, i == NONE);
      for (u32 k = 0; k < count; ++k) EXPECT_EQ(b.contact_slots[i + k], (rows + k) * PACK + lane);
    }
    EXPECT_EQ(b.block_rows[block].first, rows);
    EXPECT_EQ(b.block_rows[block].count, most);
    rows += most;
  }
  EXPECT_EQ(b.counters[COUNTER_ROWS], rows);
  EXPECT_EQ(b.counters[COUNTER_ROWS_NEEDED], rows);
}

TYPED_TEST(PackContacts, KernelMatchesReference) {
  using real = TypeParam;
  run_twins(Stage::pack_contacts, colored_pairs<real>(1, 1, 1, 0));
  run_twins(Stage::pack_contacts, colored_pairs<real>(2, 300, 7, 3));
  run_twins(Stage::pack_contacts, colored_pairs<real>(3, 3000, 40, 100));
  InitialState<real> none = colored_pairs<real>(4, 10, 3, 0);
  none.buffers.counters[COUNTER_CONTACTS] = 0;
  run_twins(Stage::pack_contacts, none);
}

TYPED_TEST(PackContacts, SortsByColorAndSizeAndPadsToBlocks) {
  using real = TypeParam;
  for (const auto& [pairs, colors, overflow] :
       {std::array<u32, 3>{1, 1, 0}, {16, 1, 0}, {17, 1, 1}, {1000, 3, 0}, {2000, 64, 30}}) {
    SCOPED_TRACE(pairs);
    InitialState<real> state = colored_pairs<real>(pairs, pairs, colors, overflow);
    reference::run_stage(Stage::pack_contacts, state.buffers, state.params);
    expect_packed(state.buffers, state.params.bodies);
  }
}

TYPED_TEST(PackContacts, TellsCentralContactsFromGeneralOnes) {
  using real = TypeParam;
  // a sphere on: another, one off the centre of its body, an anisotropic body; each on a static body of that shape
  const Graph graph = {{0, 1}, {0, 2}, {0, 3}, {0, 4}, {2, 4}};
  InitialState<real> state =
      contact_graphs<real>({{BODY_DYNAMIC, BODY_DYNAMIC, BODY_DYNAMIC, BODY_DYNAMIC, BODY_STATIC}}, {graph});
  Buffers<real>& b = state.buffers;
  b.shape_infos[2].flags = 0;
  b.body_infos[3].isotropic = 0;
  b.shape_infos[4].flags = 0;
  b.body_infos[4].isotropic = 0;
  for (u32 i = 0; i < graph.size(); ++i) b.contact_colors[i] = i;
  reference::run_stage(Stage::pack_contacts, b, state.params);
  const std::array<u32, 5> expected = {BLOCK_CENTRAL, BLOCK_GENERAL, BLOCK_GENERAL, BLOCK_CENTRAL, BLOCK_GENERAL};
  for (u32 i = 0; i < graph.size(); ++i) EXPECT_EQ(b.block_bodies[i].kind[0], expected[i]) << i;
}

// A step that needs more blocks or rows than there is room for is aborted: it says how many, and writes none outside.
TYPED_TEST(PackContacts, ReportsMissingRows) {
  using real = TypeParam;
  InitialState<real> state = colored_pairs<real>(6, 900, 9, 20);
  state.sizes.rows = state.params.row_capacity = 30;
  resize(state.buffers, state.sizes, state.features);
  const Buffers<real> after = run_twins(Stage::pack_contacts, state);
  EXPECT_EQ(after.counters[COUNTER_STATUS], u32{STATUS_ROWS_FULL});
  EXPECT_EQ(after.counters[COUNTER_ROWS], 30u);
  const u32 last = after.counters[COUNTER_BLOCKS] - 1;
  EXPECT_EQ(after.counters[COUNTER_ROWS_NEEDED], after.block_rows[last].first + after.block_rows[last].count);
}

TYPED_TEST(PackContacts, ReportsMissingBlocks) {
  using real = TypeParam;
  InitialState<real> state = colored_pairs<real>(5, 900, 9, 20);
  state.sizes.blocks = state.params.block_capacity = 12;
  resize(state.buffers, state.sizes, state.features);
  const Buffers<real> after = run_twins(Stage::pack_contacts, state);
  EXPECT_EQ(after.counters[COUNTER_STATUS], u32{STATUS_BLOCKS_FULL});
  EXPECT_EQ(after.counters[COUNTER_BLOCKS], 12u);
  EXPECT_EQ(after.counters[COUNTER_BLOCKS_NEEDED], after.color_starts[MAX_COLORS + 1]);
  EXPECT_GT(after.counters[COUNTER_BLOCKS_NEEDED], 12u);
}

}  // namespace
}  // namespace lockstep::test::pack_contacts_test
