#include "tests/particle_scenes.hpp"

namespace lockstep::store_springs_test {
namespace {

TEST(StoreSprings, KeepsEachStretchUnderItsKeyInOrder) {
  const Buffers<double> after = after_particle_stage(Stage::store_springs, lively_state<double>(3, sprung));
  ASSERT_EQ(after.spring_count[0], after.counters[COUNTER_PAIRS]);
  for (u32 k = 0; k < after.spring_count[0]; ++k) {
    const SpringKey& key = after.spring_keys[k];
    ASSERT_LE(after.neighbour_starts[key.particle], k);
    ASSERT_GT(after.neighbour_starts[key.particle + 1], k);
    ASSERT_EQ(key.partner, after.neighbours[k]);
    ASSERT_EQ(after.spring_stretches[k].y, after.stretches[k].y);
    if (k == 0) continue;
    const SpringKey& last = after.spring_keys[k - 1];
    ASSERT_LT(std::pair(last.particle, last.partner), std::pair(key.particle, key.partner));
  }
}

// What is stored is what the next step begins with.
TEST(StoreSprings, ComesBackThroughMatch) {
  InitialState<float> state = lively_state<float>(3, sprung);
  state.buffers = after_particle_stage(Stage::store_springs, state);
  ReferenceBackend<float> backend(state);
  backend.run(Stage::match_springs, state.params);
  for (u32 k = 0; k < state.buffers.spring_count[0]; ++k)
    ASSERT_EQ(backend.buffers().stretches[k].z, state.buffers.stretches[k].z);
}

TEST(StoreSprings, KernelMatchesReference) {
  const Buffers<float> after = expect_particle_twins_agree(Stage::store_springs, lively_state<float>(3, sprung));
  EXPECT_GT(after.spring_count[0], 1000u);
  expect_particle_twins_agree(Stage::store_springs, lively_state<double>(3, sprung));
}

TEST(StoreSprings, AnAbortedStepKeepsThoseOfTheLast) {
  InitialState<float> state = lively_state<float>(3, sprung);
  const u32 count = state.buffers.spring_count[0];
  state.buffers.counters[COUNTER_STATUS] = STATUS_PAIRS_FULL;
  state.buffers.neighbour_starts.back() = count + 7;
  ReferenceBackend<float> backend(state);
  backend.run(Stage::store_springs, state.params);
  EXPECT_EQ(backend.buffers().spring_count[0], count);
}

}  // namespace
}  // namespace lockstep::store_springs_test
