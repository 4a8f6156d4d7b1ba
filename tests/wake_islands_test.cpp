#include "cpu_reference/wake_islands.hpp"

#include "tests/sleepers.hpp"

namespace lockstep::test::wake_islands_test {
namespace {

template <class real>
Buffers<real> wake(const InitialState<real>& state) {
  return run_one_stage<real>(Stage::wake_islands, state.buffers, state.sizes, state.features, state.params);
}

TEST(WakeIslands, KernelMatchesReference) {
  for (const u32 seed : {1u, 2u, 3u}) {
    // from where hardly anybody is touched to where everybody is
    wake(sleeping_graphs<float>(seed, 1 + seed, 40 * seed, 10, 5, 2));
    wake(sleeping_graphs<float>(seed, 2, 200, 300 * seed, 20, 1));
  }
  wake(sleeping_graphs<double>(7, 3, 100, 60, 10, 2));
}

// Two islands of two bodies, 0 1 and 2 3; 4 is awake, 5 kinematic, 6 static; 7 and 8 in another world.
InitialState<float> two_islands(const Graph& contacts) {
  const std::vector<BodyKind> kinds = {BODY_DYNAMIC, BODY_DYNAMIC,   BODY_DYNAMIC, BODY_DYNAMIC,
                                       BODY_DYNAMIC, BODY_KINEMATIC, BODY_STATIC};
  InitialState<float> state = contact_graphs<float>({kinds, {BODY_DYNAMIC, BODY_DYNAMIC}}, {contacts, {}});
  Random random(1);
  add_sleepers(state, random, 2, 10);
  for (Motion<float>& motion : state.buffers.motions) motion = {};
  state.buffers.sleepers = {{0, 0}, {0, 0}, {0, 2}, {0, 2}, {3, NONE}, {0, NONE}, {0, NONE}, {0, 7}, {0, 7}};
  return state;
}

std::vector<u32> islands_after(const InitialState<float>& state, bool woken) {
  const Buffers<float> after = wake(state);
  EXPECT_EQ((after.counters[COUNTER_STATUS] & STATUS_WOKEN) != 0, woken);
  std::vector<u32> islands;
  for (const Sleeper& sleeper : after.sleepers) islands.push_back(sleeper.island);
  return islands;
}

constexpr u32 wakes = ISLAND_WAKES;

TEST(WakeIslands, WakeWholeWhereABodyThatIsAwakeTouchesOne) {
  EXPECT_EQ(islands_after(two_islands({{3, 4}}), true), (std::vector<u32>{0, 0, wakes, wakes, NONE, NONE, NONE, 7, 7}));
}

TEST(WakeIslands, SleepOnWhereNothingThatMovesTouchesThem) {
  EXPECT_EQ(islands_after(two_islands({{0, 1}, {1, 6}, {3, 5}}), false),
            (std::vector<u32>{0, 0, 2, 2, NONE, NONE, NONE, 7, 7}));
}

TEST(WakeIslands, WakeWhereAKinematicBodyMovesAndTouchesThem) {
  InitialState<float> state = two_islands({{1, 5}});
  state.buffers.motions[5].w[2] = 0.5f;
  EXPECT_EQ(islands_after(state, true), (std::vector<u32>{wakes, wakes, 2, 2, NONE, NONE, NONE, 7, 7}));
}

// What sleeps needs room beside what is in contact: there must be room for all of both.
TEST(WakeIslands, AskForRoomForWhatWillSleep) {
  InitialState<float> state = two_islands({{3, 6}});
  state.buffers.counters[COUNTER_CONTACTS_NEEDED] = 1;
  state.buffers.slept_count[0] = state.params.contact_capacity;
  const Buffers<float> after = wake(state);
  EXPECT_EQ(after.counters[COUNTER_STATUS], u32(STATUS_CONTACTS_FULL));
  EXPECT_EQ(after.counters[COUNTER_CONTACTS_NEEDED], state.params.contact_capacity + 1);
}

}  // namespace
}  // namespace lockstep::test::wake_islands_test
