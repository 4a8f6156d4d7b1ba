#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/event_worlds.hpp"

namespace lockstep::test::find_events_test {
namespace {

template <class real>
class FindEvents : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(FindEvents, Precisions);

using Key = std::pair<u32, u32>;

std::set<Key> random_pairs(Random& random, u32 count) {
  std::set<Key> pairs;
  while (pairs.size() < count) {
    const u32 a = random.bits() % 40, b = random.bits() % 40;
    if (a < b) pairs.insert({a, b});
  }
  return pairs;
}

// Candidate pairs of one contact each, some of which touch, after a step in which others did.
template <class real>
InitialState<real> touching_lists(const std::set<Key>& candidates, const std::set<Key>& current,
                                  const std::set<Key>& before) {
  InitialState<real> state =
      make_event_worlds<real>({std::vector<BodyDescription>(40, sphere_body({0, 0, 0}, 1))}, 512);
  Buffers<real>& b = state.buffers;
  std::ranges::fill(b.counters, 0u);
  b.step_index[0] = 77;
  u32& count = b.counters[COUNTER_PAIRS];
  for (const auto& [a, c] : candidates) {
    b.pairs[count] = {a, c};
    b.contact_starts[count] = count;
    b.touched[count] = current.count({a, c}) ? 1 : 0;
    ++count;
  }
  b.counters[COUNTER_CONTACTS] = b.contact_starts[count] = count;
  for (u32 a = 0; a <= 40; ++a) {  // of the candidates: how many have a smaller shape a
    b.pair_starts[a] = 0;
    for (const Key& key : candidates) b.pair_starts[a] += key.first < a ? 1 : 0;
  }
  for (const auto& [a, c] : before) b.touching[b.touching_count[0]++] = {a, c};
  return state;
}

struct Lists {
  std::set<Key> candidates, current, before;
};

Lists random_lists(Random& random, u32 candidates, u32 before) {
  Lists lists = {random_pairs(random, candidates), {}, random_pairs(random, before)};
  for (const Key& key : lists.candidates) {
    if (random.bits() % 2 == 0) lists.current.insert(key);
    if (random.bits() % 3 == 0) lists.before.insert(key);
  }
  return lists;
}

TYPED_TEST(FindEvents, TellsTheDifferenceOfTwoSets) {
  using real = TypeParam;
  Random random(50);
  for (const auto& [candidates, before] : {std::pair{0u, 0u}, {0u, 20u}, {20u, 0u}, {1u, 1u}, {200u, 100u}}) {
    const Lists lists = random_lists(random, candidates, before);
    InitialState<real> state = touching_lists<real>(lists.candidates, lists.current, lists.before);
    Buffers<real>& b = state.buffers;
    reference::run_stage(Stage::find_events, b, state.params);

    std::vector<std::pair<Key, u32>> expected;
    for (u32 a = 0; a < 40; ++a) {
      for (u32 c = a + 1; c < 40; ++c) {
        const bool is = lists.current.count({a, c}), was = lists.before.count({a, c});
        if (is != was) expected.push_back({{a, c}, is ? EVENT_CONTACT_BEGIN : EVENT_CONTACT_END});
      }
    }
    ASSERT_EQ(b.counters[COUNTER_EVENTS], expected.size());
    EXPECT_EQ(b.counters[COUNTER_TOUCHES], lists.current.size());
    for (u32 i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(Key(b.events[i].shape_a, b.events[i].shape_b), expected[i].first);
      EXPECT_EQ(Key(b.events[i].body_a, b.events[i].body_b), expected[i].first);
      EXPECT_EQ(b.events[i].kind, expected[i].second);
      EXPECT_EQ(b.events[i].step, 77u);
    }
    ASSERT_EQ(b.touching_count[0], lists.current.size());
    u32 i = 0;
    for (const Key& key : lists.current) {
      EXPECT_EQ(Key(b.touching[i].shape_a, b.touching[i].shape_b), key);
      ++i;
    }
  }
}

TYPED_TEST(FindEvents, KernelMatchesReference) {
  using real = TypeParam;
  Random random(51);
  for (const auto& [candidates, before] : {std::pair{0u, 30u}, {1u, 0u}, {400u, 100u}}) {
    const Lists lists = random_lists(random, candidates, before);
    InitialState<real> state = touching_lists<real>(lists.candidates, lists.current, lists.before);
    run_one_stage(Stage::find_events, state.buffers, state.sizes, state.features, state.params, launches());
    state.buffers.counters[COUNTER_STATUS] = STATUS_BLOCKS_FULL;  // an aborted step tells nothing and forgets nothing
    const Buffers<real> after =
        run_one_stage(Stage::find_events, state.buffers, state.sizes, state.features, state.params, launches());
    EXPECT_EQ(after.counters[COUNTER_EVENTS], 0u);
    EXPECT_EQ(after.touching_count[0], state.buffers.touching_count[0]);
  }
}

// Bodies of all kinds, triggers among them: spheres and half spaces that stand still or move.
std::vector<std::vector<BodyDescription>> worlds_with_triggers() {
  std::vector<std::vector<BodyDescription>> worlds = lively_worlds();
  for (auto& world : worlds) {
    for (u32 n = 2; n < world.size(); n += 9) {
      for (ShapeDescription& shape : world[n].shapes) shape.trigger = true;
    }
  }
  worlds[1].push_back(trigger_body(plane_body()));
  worlds[1].push_back(sphere_body({0, 0, 0.1}, 0.2, {0, 0, 1}));
  return worlds;
}

TYPED_TEST(FindEvents, TwinsAgreeWithTriggers) {
  using real = TypeParam;
  const InitialState<real> state = make_event_worlds<real>(worlds_with_triggers(), 100000);
  Simulation<real> simulation = simulate_in_reference(state);
  u32 found[EVENT_IMPACT] = {};  // the kinds before it
  for (int i = 0; i < 4; ++i) {
    simulation.step();
    for (const Event& event : simulation.events()) ++found[event.kind];
  }
  for (const u32 count : found) EXPECT_GT(count, 10u);
  expect_twins_agree(state, 4, launches_of_a_step<real>());
}

// A ball dropped from 0.2 m without loss: it touches every sqrt(8 h / g) = 0.4 s or so, for one step each time.
TYPED_TEST(FindEvents, ABouncingBallBeginsAndEnds) {
  using real = TypeParam;
  InitialState<real> state = make_event_worlds<real>({{plane_body(), sphere_body({0, 0, 0.7}, 0.5)}}, 16);
  state.buffers.material_pairs[0].restitution = 1;
  state.params.dt = real(1) / 1000;
  state.params.theta = real(0.5);
  Simulation<real> simulation = simulate_in_reference(state);
  const double half = std::sqrt(2 * 0.2 / 9.81);
  std::vector<u32> begins, ends;
  for (u32 i = 0; i < 2000; ++i) {
    simulation.step();
    for (const Event& event : simulation.events()) {
      EXPECT_EQ(event.step, i);
      EXPECT_EQ(event.body_a, 1u);  // a plane is side b
      (event.kind == EVENT_CONTACT_BEGIN ? begins : ends).push_back(i);
    }
  }
  ASSERT_EQ(begins.size(), 5u);
  for (u32 n = 0; n < 5; ++n) {
    EXPECT_NEAR(begins[n] * 1e-3, (2 * n + 1) * half, 0.003 + 0.002 * n);
    EXPECT_EQ(ends[n], begins[n] + 1);
  }
}

// At rest nothing flickers, and within a step's sub-steps a touch is not missed.
TYPED_TEST(FindEvents, ABallAtRestKeepsTouching) {
  using real = TypeParam;
  for (const u32 substeps : {1u, 4u}) {
    InitialState<real> state = make_event_worlds<real>({{plane_body(), sphere_body({0, 0, 0.6}, 0.5, {1, 0, 0})}}, 16);
    state.params.dt = real(1.0 / 60 / substeps);
    state.params.substeps = substeps;
    state.params.theta = 1;
    Simulation<real> simulation = simulate_in_reference(state);
    std::vector<std::string> events;
    for (u32 i = 0; i < 300; ++i) {
      simulation.step();
      for (const Event& event : simulation.events()) events.push_back(describe(event));
    }
    EXPECT_EQ(events, std::vector<std::string>{"begin 1 0"});
  }
}

// In the first of four sub-steps the ball bounces, in the others it flies away: it did touch.
TYPED_TEST(FindEvents, ABounceWithinAStepIsSeen) {
  using real = TypeParam;
  InitialState<real> state = make_event_worlds<real>({{plane_body(), sphere_body({0, 0, 0.51}, 0.5, {0, 0, -5})}}, 16);
  state.buffers.material_pairs[0].restitution = 1;
  state.params.dt = real(1.0 / 240);
  state.params.substeps = 4;
  state.params.theta = 1;
  Simulation<real> simulation = simulate_in_reference(state);
  simulation.step();
  ASSERT_EQ(simulation.events().size(), 1u);
  EXPECT_EQ(describe(simulation.events()[0]), "begin 1 0");
  simulation.step();
  ASSERT_EQ(simulation.events().size(), 1u);
  EXPECT_EQ(describe(simulation.events()[0]), "end 1 0");
}

// A ball falls through a trigger of radius 0.3 at the origin: inside while the centres are less than 0.4 apart. Nothing
// pushes it: the path is that of free fall.
TYPED_TEST(FindEvents, ATriggerReportsWhoEntersAndLeaves) {
  using real = TypeParam;
  InitialState<real> state = make_event_worlds<real>(
      {{sphere_body({9, 9, 9}, 0.1)},
       {sphere_body({0, 0, 1}, 0.1), trigger_body(sphere_body({0, 0, 0}, 0.3)), sphere_body({0.2, 0, 0}, 0.2)}},
      16);
  state.buffers.body_infos[3].kind = BODY_STATIC;  // not felt: triggers feel dynamic bodies, through other filters too
  state.buffers.motions[3].inverse_mass = 0;
  state.buffers.shape_infos[3].category = state.buffers.shape_infos[1].category << 1;
  state.buffers.shape_infos[1].mask = state.buffers.shape_infos[1].category;
  state.params.dt = real(1) / 1000;
  state.params.theta = real(0.5);
  Simulation<real> simulation = simulate_in_reference(state);
  std::vector<Event> events;
  for (u32 i = 0; i < 700; ++i) {
    simulation.step();
    for (const Event& event : simulation.events()) events.push_back(event);
  }
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(describe(events[0]), "enter 1 0");  // the trigger is side a, though its body is the later one
  EXPECT_EQ(describe(events[1]), "leave 1 0");
  EXPECT_EQ(events[0].world, 1u);
  EXPECT_NEAR(events[0].step, 1000 * std::sqrt(2 * 0.6 / 9.81), 1.5);
  EXPECT_NEAR(events[1].step, 1000 * std::sqrt(2 * 1.4 / 9.81), 1.5);
  const Buffer wanted[] = {Buffer::positions};
  EXPECT_NEAR(double(simulation.backend().download(wanted).positions[1].z), 1 - 0.5 * 9.81 * 0.7 * 0.7, 1e-4);
  EXPECT_EQ(simulation.counters()[COUNTER_CONTACTS], 0u);
}

// Lists that were too short change no event, and none is told twice.
TYPED_TEST(FindEvents, ARedoneStepTellsTheSame) {
  using real = TypeParam;
  const InitialState<real> ample = make_event_worlds<real>(worlds_with_triggers(), 100000);
  InitialState<real> tight = ample;
  tight.sizes.pairs = tight.sizes.contacts = tight.sizes.blocks = tight.sizes.rows = 1;
  tight.params.pair_capacity = tight.params.contact_capacity = tight.params.block_capacity = tight.params.row_capacity =
      1;
  resize(tight.buffers, tight.sizes, tight.features);
  Simulation<real> one = simulate_in_reference(ample), other = simulate_in_reference(tight);
  for (int i = 0; i < 3; ++i) {
    one.step();
    other.step();
    const std::vector<Event> expected = one.events(), events = other.events();
    ASSERT_EQ(events.size(), expected.size());
    for (u32 k = 0; k < events.size(); ++k) {
      EXPECT_EQ(describe(events[k]), describe(expected[k]));
      EXPECT_EQ(events[k].world, expected[k].world);
    }
  }
  EXPECT_GT(other.redone(), 0u);
  EXPECT_EQ(one.world_hashes()[0].state_low, other.world_hashes()[0].state_low);
}

}  // namespace
}  // namespace lockstep::test::find_events_test
