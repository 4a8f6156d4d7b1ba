#include <gtest/gtest.h>

#include <map>
#include <set>

#include "tests/cell_scene.hpp"

namespace lockstep::test::schedule_contacts_test {
namespace {

template <class real>
class ScheduleContacts : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ScheduleContacts, Precisions);

template <class real>
InitialState<real> partitioned(InitialState<real> state) {
  reference::run_stage(Stage::partition_contacts, state.buffers, state.params);
  return state;
}

template <class real>
InitialState<real> star_in_a_cell(u32 count, BodyKind hub = BODY_DYNAMIC) {
  const auto [kinds, graph] = star(count, hub);
  InitialState<real> state = contact_graphs<real>({kinds}, {graph});
  use_cells(state, 1);
  return state;
}

// A work-item in order and work-groups in rounds find the same.
TYPED_TEST(ScheduleContacts, KernelMatchesReference) {
  using real = TypeParam;
  run_twins(Stage::schedule_contacts, partitioned(graphs_in_cells<real>(1, {{3, 5}, {400, 1500}, {1, 2}})));
  run_twins(Stage::schedule_contacts, partitioned(graphs_in_cells<real>(2, {{5, 0}})));
  run_twins(Stage::schedule_contacts, partitioned(graphs_in_cells<real>(3, {{30, 1500}})));  // bodies with many pairs
  run_twins(Stage::schedule_contacts, partitioned(star_in_a_cell<real>(200)));
  run_twins(Stage::schedule_contacts, partitioned(star_in_a_cell<real>(2000, BODY_STATIC)));  // more than batches hold
}

// Batches whose pairs share no movable body, filled from the first on: a pair is passed over by those before its own
// alone where they are full or have one of its bodies.
TYPED_TEST(ScheduleContacts, BatchesAreProperAndFilledInOrder) {
  using real = TypeParam;
  const InitialState<real> state = scheduled(graphs_in_cells<real>(4, {{200, 2000}, {60, 300}}));
  const Buffers<real>& b = state.buffers;
  u32 block = 0, row = 0, in_cells = 0;
  for (u32 cell = 0; cell + 1 < b.cell_starts.size(); ++cell) {
    EXPECT_EQ(b.cell_blocks[cell], block);
    EXPECT_EQ(b.cell_rows[cell], row);
    std::map<u32, std::map<u32, u32>> batches;  // first contacts by batch and lane
    for (u32 k = b.cell_starts[cell]; k < b.cell_starts[cell + 1]; ++k) {
      const u32 i = b.cell_pairs[k], slot = b.cell_slots[i];
      if (slot == NONE) continue;
      ++in_cells;
      EXPECT_TRUE(batches[slot / PACK].emplace(slot % PACK, i).second) << "two pairs in a lane";
    }
    for (u32 batch = 0; batch < batches.size(); ++batch) {
      ASSERT_TRUE(batches.contains(batch));
      std::set<u32> bodies;
      u32 last_points = MANIFOLD_POINTS, lane = 0;
      for (const auto& [at, i] : batches[batch]) {
        EXPECT_EQ(at, lane++);
        const u32 points = reference::pair_contact_count(b, i);
        EXPECT_LE(points, last_points);
        if (at == 0) row += points;
        last_points = points;
        for (const u32 body : movable_bodies(b, i)) EXPECT_TRUE(bodies.insert(body).second) << "body " << body;
      }
      for (u32 later = batch + 1; later < batches.size(); ++later) {
        for (const auto& [at, i] : batches[later]) {
          bool passed_over = batches[batch].size() == PACK;
          for (const u32 body : movable_bodies(b, i)) passed_over |= bodies.contains(body);
          EXPECT_TRUE(passed_over) << "contact " << i << " of batch " << later << " fits into batch " << batch;
        }
      }
    }
    block += u32(batches.size());
  }
  EXPECT_EQ(b.cell_blocks.back(), block);
  EXPECT_EQ(b.cell_rows.back(), row);
  EXPECT_GT(in_cells, 500u);
  EXPECT_GT(block, 50u);
}

// What finds no batch is left to the colours.
TYPED_TEST(ScheduleContacts, AStarRunsOutOfBatches) {
  using real = TypeParam;
  InitialState<real> state = scheduled(star_in_a_cell<real>(200));
  for (u32 i = 0; i < 200; ++i) EXPECT_EQ(state.buffers.cell_slots[i], i < CELL_BATCHES ? i * PACK : NONE) << i;
  for (const Stage stage : {Stage::color_contacts, Stage::pack_contacts})
    reference::run_stage(stage, state.buffers, state.params);
  EXPECT_EQ(state.buffers.counters[COUNTER_COLORS], MAX_COLORS);
  EXPECT_EQ(state.buffers.counters[COUNTER_OVERFLOW], 200 - CELL_BATCHES - MAX_COLORS);
  EXPECT_EQ(state.buffers.counters[COUNTER_BLOCKS], 200u);
}

// Pairs that share nothing fill batches whole.
TYPED_TEST(ScheduleContacts, WhatRestsOnTheGroundFillsBatches) {
  using real = TypeParam;
  const InitialState<real> state = scheduled(star_in_a_cell<real>(200, BODY_STATIC));
  for (u32 i = 0; i < 200; ++i) EXPECT_EQ(state.buffers.cell_slots[i], i) << i;
}

// A world of a batch is scheduled as it is alone.
TYPED_TEST(ScheduleContacts, WorldsDoNotMeet) {
  using real = TypeParam;
  const InitialState<real> alone = scheduled(graphs_in_cells<real>(5, {{60, 300}}));
  const InitialState<real> batch = scheduled(graphs_in_cells<real>(5, {{60, 300}, {60, 300}}));
  const u32 contacts = alone.buffers.counters[COUNTER_CONTACTS];
  InitialState<real> behind = batch;  // the second world with the slots of the first
  const u32 bodies = alone.params.bodies, first = behind.buffers.world_ranges[1].first_body;
  for (u32 i = 0; i < bodies; ++i) behind.buffers.positions[first + i] = alone.buffers.positions[i];
  const u32 before = contacts;
  behind.buffers.counters[COUNTER_CONTACTS] = 2 * contacts;
  behind.sizes.contacts = behind.params.contact_capacity = 2 * contacts;
  resize(behind.buffers, behind.sizes, behind.features);
  for (u32 i = 0; i < contacts; ++i) {
    behind.buffers.contacts[i] = behind.buffers.contacts[before + i] = alone.buffers.contacts[i];
    Contact& second = behind.buffers.contacts[before + i];
    second.body_a += first, second.body_b += first, second.shape_a += first, second.shape_b += first;
    second.world = 1;
  }
  behind = scheduled(behind);
  u32 in_cells = 0;
  for (u32 i = 0; i < contacts; ++i) {
    EXPECT_EQ(behind.buffers.cell_slots[before + i], alone.buffers.cell_slots[i]) << i;
    in_cells += alone.buffers.cell_slots[i] != NONE;
  }
  EXPECT_GT(in_cells, 50u);
}

}  // namespace
}  // namespace lockstep::test::schedule_contacts_test
