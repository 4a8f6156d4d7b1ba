#include "cpu_reference/fall_asleep.hpp"

#include <map>
#include <set>

#include "tests/sleepers.hpp"

namespace lockstep::test::fall_asleep_test {
namespace {

// With impulses of the contacts, and those of some that sleep already, in order.
template <class real>
InitialState<real> with_impulses(InitialState<real> state, u32 seed) {
  Random random(seed);
  Buffers<real>& b = state.buffers;
  state.sizes.contacts = state.sizes.pairs = 4 * state.sizes.contacts;
  set_sizes(state.params, state.sizes);
  resize(b, state.sizes, state.features);
  const auto impulse = [&] {
    return ContactImpulse<real>{real(random.between(0, 1)), real(random.between(-1, 1)), real(random.between(-1, 1)),
                                0};
  };
  const auto point = [&] {
    ContactPoint<real> made = {};
    for (real* words : {made.anchor_a, made.anchor_b, made.normal})
      for (unsigned k = 0; k < 3; ++k) words[k] = real(random.between(-1, 1));
    return made;
  };
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    b.cached_impulses[i] = impulse();
    b.contact_points[i] = point();
    b.contacts[i].normal = random.bits() % 3;
  }
  std::set<std::array<u32, 3>> keys;
  std::map<u32, std::vector<u32>> islands;
  for (u32 i = 0; i < b.sleepers.size(); ++i) islands[b.sleepers[i].island].push_back(i);
  for (const auto& [island, bodies] : islands) {
    // of those who have been woken, too: they go
    if (island == NONE) continue;
    for (u32 n = 0; n < bodies.size(); ++n) {
      const u32 a = bodies[n], c = bodies[random.bits() % bodies.size()];
      if (a < c && keys.size() < state.sizes.contacts / 2) keys.insert({a, c, random.bits() % 3});
    }
  }
  for (const auto& [a, c, feature] : keys) {
    b.slept_keys[b.slept_count[0]] = {a, c, feature, random.bits() % 3};
    b.slept_points[b.slept_count[0]] = point();
    b.slept_impulses[b.slept_count[0]++] = impulse();
  }
  return state;
}

template <class real>
Buffers<real> sleep(const InitialState<real>& state) {
  return run_one_stage<real>(Stage::fall_asleep, state.buffers, state.sizes, state.features, state.params);
}

TEST(FallAsleep, KernelMatchesReference) {
  u32 fell = 0;
  for (const u32 seed : {1u, 2u, 3u}) {
    const auto few = with_impulses(sleeping_graphs<float>(seed, 1 + seed, 60 * seed, 15 * seed, 5, 6), seed);
    const auto many = with_impulses(sleeping_graphs<float>(seed, 2, 200, 300 * seed, 20, 5), seed);
    const Buffers<float> after = sleep(few);
    fell += after.counters[COUNTER_CHANGED];
    sleep(many);
    // nobody moves: large islands
    InitialState<float> still = many;
    let_rest(still);
    for (Sleeper& sleeper : still.buffers.sleepers) sleeper.still = 7;
    sleep(still);
  }
  EXPECT_EQ(fell, 3u);
  sleep(with_impulses(sleeping_graphs<double>(9, 2, 100, 60, 10, 6), 9));
}

// A chain of sleep candidates in any order of names is one island, named by the smallest.
TEST(FallAsleep, IslandsAreNamedByTheirFirstBody) {
  constexpr u32 count = 500;
  Random random(5);
  std::vector<u32> order(count);
  std::iota(order.begin(), order.end(), 0u);
  for (u32 i = count; i-- > 1;) std::swap(order[i], order[random.bits() % (i + 1)]);
  Graph chain;
  for (u32 i = 1; i < count; ++i) {
    // three pieces
    if (i != 100 && i != 300) chain.push_back(std::minmax(order[i - 1], order[i]));
  }
  std::sort(chain.begin(), chain.end());
  InitialState<float> state = contact_graphs<float>({std::vector<BodyKind>(count, BODY_DYNAMIC)}, {chain});
  add_sleepers(state, random, 10, 10);
  let_rest(state);
  for (Sleeper& sleeper : state.buffers.sleepers) sleeper = {4, NONE};
  state.buffers.motions[order[40]].v[0] = 1;  // keeps the first piece awake
  const Buffers<float> after = sleep(state);
  const u32 second = *std::min_element(order.begin() + 100, order.begin() + 300);
  const u32 third = *std::min_element(order.begin() + 300, order.end());
  for (u32 i = 0; i < count; ++i)
    EXPECT_EQ(after.sleepers[order[i]].island, i < 100 ? NONE : i < 300 ? second : third) << i;
  EXPECT_EQ(after.counters[COUNTER_ASLEEP], 400u);
  EXPECT_EQ(after.counters[COUNTER_ISLANDS], 2u);
  EXPECT_EQ(after.counters[COUNTER_MOVING], 100u);
  EXPECT_EQ(after.slept_count[0], 199u + 199u);
}

TEST(FallAsleep, CountsStepsOfSlowBodiesAlone) {
  InitialState<float> state = contact_graphs<float>({std::vector<BodyKind>(6, BODY_DYNAMIC)}, {{}});
  Random random(1);
  add_sleepers(state, random, 2, 10);
  Buffers<float>& b = state.buffers;
  let_rest(state);
  b.sleepers = {{3, NONE}, {3, NONE}, {4, NONE}, {4, NONE}, {4, ISLAND_WAKES}, {NONE, NONE}};
  b.motions[1].v[2] = 0.011f;   // faster than 0.01 m/s
  b.motions[3].w[0] = 0.0501f;  // than 0.05 rad/s
  b.motions[2].v[1] = 0.009f;
  const Buffers<float> after = sleep(state);
  const std::vector<std::pair<u32, u32>> expected = {{4, NONE}, {0, NONE}, {0, 2}, {0, NONE}, {0, 4}, {0, 5}};
  for (u32 i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(after.sleepers[i].still, expected[i].first) << i;
    EXPECT_EQ(after.sleepers[i].island, expected[i].second) << i;
  }
  EXPECT_EQ(after.motions[2].v[1], 0.0f);
}

TEST(FallAsleep, AKinematicBodyThatMovesKeepsAwakeWhatTouchesIt) {
  const std::vector<BodyKind> kinds = {BODY_DYNAMIC, BODY_DYNAMIC, BODY_KINEMATIC, BODY_STATIC};
  for (const bool moves : {false, true}) {
    InitialState<float> state = contact_graphs<float>({kinds}, {{{0, 1}, {0, 3}, {1, 2}}});
    Random random(1);
    add_sleepers(state, random, 2, 10);
    let_rest(state);
    for (u32 i = 0; i < 2; ++i) state.buffers.sleepers[i] = {8, NONE};
    state.buffers.motions[2].v[0] = moves ? 0.001f : 0.0f;
    const Buffers<float> after = sleep(state);
    EXPECT_EQ(after.counters[COUNTER_ASLEEP], moves ? 0u : 2u);
    EXPECT_EQ(after.counters[COUNTER_MOVING], moves ? 3u : 0u);
  }
}

}  // namespace
}  // namespace lockstep::test::fall_asleep_test
