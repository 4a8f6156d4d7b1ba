#include <gtest/gtest.h>

#include <set>

#include "tests/contact_scene.hpp"

namespace lockstep::test::color_contacts_test {
namespace {

template <class real>
class ColorContacts : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ColorContacts, Precisions);

// Colours of pairs on the dynamic bodies, each at most once; smaller colours are only passed over where a body has
// them.
template <class real>
void expect_greedy_colors(const Buffers<real>& b) {
  std::vector<std::set<u32>> taken(b.body_infos.size());
  const auto dynamic_bodies = [&](const Contact& contact) {
    std::vector<u32> bodies;
    for (const u32 body : {contact.body_a, contact.body_b})
      if (b.body_infos[body].kind == BODY_DYNAMIC) bodies.push_back(body);
    return bodies;
  };
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    const bool first = reference::pair_contact_count(b, i) > 0;
    ASSERT_EQ(b.contact_colors[i] == COLOR_OF_FIRST, !first);
    if (!first || b.contact_colors[i] == MAX_COLORS) continue;
    for (const u32 body : dynamic_bodies(b.contacts[i])) {
      EXPECT_TRUE(taken[body].insert(b.contact_colors[i]).second) << "contact " << i << " shares its colour";
    }
  }
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    if (b.contact_colors[i] == COLOR_OF_FIRST) continue;
    for (u32 color = 0; color < b.contact_colors[i]; ++color) {
      bool passed_over = false;
      for (const u32 body : dynamic_bodies(b.contacts[i])) passed_over |= taken[body].contains(color);
      EXPECT_TRUE(passed_over) << "contact " << i << " could have colour " << color;
    }
  }
  for (u32 body = 0; body < taken.size(); ++body) {
    u32 mask[2] = {0, 0};
    for (const u32 color : taken[body]) mask[color / 32] |= 1u << (color % 32);
    EXPECT_EQ(b.body_colors[2 * body], mask[0]);
    EXPECT_EQ(b.body_colors[2 * body + 1], mask[1]);
  }
}

TYPED_TEST(ColorContacts, KernelMatchesReference) {
  using real = TypeParam;
  run_twins(Stage::color_contacts, random_worlds<real>(1, {{3, 5}, {400, 1500}, {1, 2}}));
  run_twins(Stage::color_contacts, random_worlds<real>(2, {{30, 1500}}));
  run_twins(Stage::color_contacts, random_worlds<real>(3, {{5, 0}}));
  const auto [kinds, graph] = star(200);
  run_twins(Stage::color_contacts, contact_graphs<real>({kinds}, {graph}));
}

TYPED_TEST(ColorContacts, IsProperAndGreedy) {
  using real = TypeParam;
  for (const u32 contacts : {1u, 50u, 700u, 3000u}) {
    SCOPED_TRACE(contacts);
    InitialState<real> state = random_worlds<real>(contacts, {{120, contacts}});
    reference::run_stage(Stage::color_contacts, state.buffers, state.params);
    expect_greedy_colors(state.buffers);
  }
}

// A world of a batch is coloured as it is alone.
TYPED_TEST(ColorContacts, WorldsDoNotMeet) {
  using real = TypeParam;
  Random random(7);
  const auto [kinds, graph] = random_graph(random, 40, 130);
  const auto [other_kinds, other_graph] = random_graph(random, 60, 300);
  InitialState<real> alone = contact_graphs<real>({kinds}, {graph});
  InitialState<real> batch = contact_graphs<real>({other_kinds, kinds}, {other_graph, graph});
  reference::run_stage(Stage::color_contacts, alone.buffers, alone.params);
  reference::run_stage(Stage::color_contacts, batch.buffers, batch.params);
  for (u32 i = 0; i < graph.size(); ++i)
    EXPECT_EQ(alone.buffers.contact_colors[i], batch.buffers.contact_colors[other_graph.size() + i]);
}

TYPED_TEST(ColorContacts, StarRunsOutOfColors) {
  using real = TypeParam;
  const auto [kinds, graph] = star(200);
  InitialState<real> state = contact_graphs<real>({kinds}, {graph});
  reference::run_stage(Stage::color_contacts, state.buffers, state.params);
  expect_greedy_colors(state.buffers);
  std::vector<u32> sizes(MAX_COLORS + 1, 0);
  for (u32 i = 0; i < graph.size(); ++i) ++sizes[state.buffers.contact_colors[i]];
  for (u32 color = 0; color < MAX_COLORS; ++color) EXPECT_EQ(sizes[color], 1u);
  EXPECT_EQ(sizes[MAX_COLORS], 200 - MAX_COLORS);
}

// What many bodies rest on costs no colours.
TYPED_TEST(ColorContacts, ImmovableBodiesTakeNoColor) {
  using real = TypeParam;
  for (const BodyKind hub : {BODY_STATIC, BODY_KINEMATIC}) {
    const auto [kinds, graph] = star(200, hub);
    InitialState<real> state = contact_graphs<real>({kinds}, {graph});
    reference::run_stage(Stage::color_contacts, state.buffers, state.params);
    for (u32 i = 0; i < graph.size(); ++i) EXPECT_EQ(state.buffers.contact_colors[i], 0u);
    EXPECT_EQ(state.buffers.body_colors[0], 0u);
  }
}

}  // namespace
}  // namespace lockstep::test::color_contacts_test
