#include "tests/particle_scenes.hpp"

namespace lockstep::match_springs_test {
namespace {

template <class real>
void expect_what_a_search_through_all_finds() {
  const InitialState<real> state = lively_state<real>(5, sprung);
  const Buffers<real> after = after_particle_stage(Stage::match_springs, state);
  u32 known = 0, unknown = 0;
  for (u32 i = 0; i < state.sizes.particles; ++i) {
    for (u32 k = after.neighbour_starts[i]; k < after.neighbour_starts[i + 1]; ++k) {
      Vec4<real> expected = {0, 0, 0, 0};
      bool found = false;
      for (u32 s = 0; s < state.buffers.spring_count[0]; ++s) {
        const SpringKey& key = state.buffers.spring_keys[s];
        if (key.particle != i || key.partner != after.neighbours[k]) continue;
        expected = state.buffers.spring_stretches[s];
        found = true;
      }
      const Vec4<real>& stretch = after.stretches[k];
      ASSERT_TRUE(stretch.x == expected.x && stretch.y == expected.y && stretch.z == expected.z && stretch.w == 0);
      known += stretch.x != 0;
      unknown += !found;
    }
  }
  EXPECT_GT(known, 200u);
  EXPECT_GT(unknown, 3u) << "some come near that were not";
}
TEST(MatchSprings, FindsWhatASearchThroughAllFinds) {
  expect_what_a_search_through_all_finds<float>();
  expect_what_a_search_through_all_finds<double>();
}

TEST(MatchSprings, WithoutAMemoryAllBeginWithNone) {
  InitialState<double> state = lively_state<double>(5, sprung);
  state.buffers.spring_count[0] = 0;
  const Buffers<double> after = after_particle_stage(Stage::match_springs, state);
  for (u32 k = 0; k < after.counters[COUNTER_PAIRS]; ++k) ASSERT_EQ(after.stretches[k].x, 0);
}

TEST(MatchSprings, KernelMatchesReference) {
  expect_particle_twins_agree(Stage::match_springs, lively_state<float>(5, sprung));
  expect_particle_twins_agree(Stage::match_springs, lively_state<double>(5, sprung));
  expect_particle_twins_agree(Stage::match_springs, lively_state<float>(0, sprung));
}

}  // namespace
}  // namespace lockstep::match_springs_test
