// Who falls asleep and when, who wakes whom, and that sleep changes nothing else.
#include <cmath>
#include <cstring>

#include "cpu_reference/color_contacts.hpp"
#include "host/scene/compile_sleeping.hpp"
#include "host/sleepers.hpp"
#include "tests/sleeping_scenes.hpp"

namespace lockstep::test::sleeping_test {
namespace {

constexpr u32 steps_of_half_a_second = 32;

bool is_slow(const Motion<float>& m, float speed = 0.01f, float angular_speed = 0.05f) {
  const auto square = [](const float(&a)[3]) { return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]; };
  return square(m.v) <= speed * speed && square(m.w) <= angular_speed * angular_speed;
}

TEST(Sleeping, AStackSleepsWhenAllHaveBeenAtRestForTheTimeTold) {
  // let fall from 2 mm, so that it has to come to rest first
  const std::string bodies = box(0, 0.502) + ", " + box(0, 1.504) + ", " + box(0.1, 2.506);
  Simulation<float> awake = on_reference(compile<float>(scene_of(bodies, R"("sleeping": {"after": 1e9})")));
  Simulation<float> simulation = on_reference(compile<float>(scene_of(bodies)));
  std::vector<std::vector<Vec4<float>>> path;  // by step
  u32 slow_steps = 0;                          // of all at once, and so slow that they are at rest
  while (!sleeps(simulation, 1)) {
    ASSERT_LT(simulation.steps_done(), 200u);
    ASSERT_LT(slow_steps, 3 * steps_of_half_a_second);
    for (u32 body = 2; body <= 3; ++body) EXPECT_FALSE(sleeps(simulation, body)) << simulation.steps_done();
    awake.step();
    simulation.step();
    path.push_back(state_of(awake).positions);
    const auto& motions = state_of(awake).motions;
    const bool slow = is_slow(motions[1]) && is_slow(motions[2]) && is_slow(motions[3]);
    slow_steps = slow ? slow_steps + 1 : 0;
  }
  EXPECT_GT(path.size(), steps_of_half_a_second + 1);  // else nothing was seen
  const double radius = std::sqrt(0.75);
  for (u32 body = 1; body <= 3; ++body) {
    EXPECT_TRUE(sleeps(simulation, body));
    for (std::size_t k = path.size() - steps_of_half_a_second; k < path.size(); ++k)
      EXPECT_NEAR(path[k][body].z, path.back()[body].z, 2 * radius / 256) << body << ", " << k;
  }
  EXPECT_EQ(simulation.counters()[COUNTER_ASLEEP], 3u);
  EXPECT_EQ(simulation.counters()[COUNTER_ISLANDS], 1u);
  // up to the step in which it fell asleep all was as without
  EXPECT_EQ(
      std::memcmp(state_of(awake).positions.data(), state_of(simulation).positions.data(), 4 * sizeof(Vec4<float>)), 0);
}

TEST(Sleeping, TimeIsCountedInSteps) {
  EXPECT_EQ(sleep_steps(0.5, 1.0 / 60), 30u);
  EXPECT_EQ(sleep_steps(0.5, 0.015625), 32u);
  EXPECT_EQ(sleep_steps(0.5, 0.3), 2u);
  EXPECT_EQ(sleep_steps(0.1, 0.01), 10u);
  EXPECT_EQ(sleep_steps(1e-9, 0.01), 2u);
  EXPECT_EQ(sleep_steps(1e30, 0.01), NONE);
}

// A kinematic body turns far away, so that steps are made whole; nothing of the stack changes.
TEST(Sleeping, AStackKeepsItsPoseForTenThousandSteps) {
  const std::string spinner = R"({"type": "kinematic", "position": [50, 0, 5], "angular_velocity": [0, 0, 0.1],
                                  "shapes": [{"type": "sphere", "radius": 0.5}]})";
  Simulation<float> simulation = on_reference(compile<float>(
      scene_of(column(0, 4) + ", " + spinner, R"("solver": "small_steps", "sleeping": {"after": 0.5})")));
  for (u32 i = 0; i < 100; ++i) simulation.step();
  ASSERT_EQ(simulation.counters()[COUNTER_ASLEEP], 4u);
  const Buffers<float> asleep = state_of(simulation);
  for (u32 i = 0; i < 10000; ++i) {
    simulation.step();
    ASSERT_EQ(simulation.counters()[COUNTER_CONTACTS], 0u);
  }
  const Buffers<float>& after = state_of(simulation);
  for (u32 body = 1; body <= 4; ++body) {
    EXPECT_EQ(std::memcmp(&after.positions[body], &asleep.positions[body], sizeof(Vec4<float>)), 0);
    EXPECT_EQ(std::memcmp(&after.orientations[body], &asleep.orientations[body], sizeof(Vec4<float>)), 0);
  }
  EXPECT_EQ(simulation.steps_done(), 10100u);
}

// What a simulation leaves out where everything sleeps is what would change nothing.
TEST(Sleeping, AStepAtRestIsTheStep) {
  for (const char* more : {"", R"("events": true, )", R"("solver": "small_steps", )"}) {
    const InitialState<float> state =
        compile<float>(scene_of(column(0, 3), std::string(more) + R"("sleeping": {"after": 0.5})"));
    Simulation<float> simulation = on_reference(state);
    while (simulation.counters()[COUNTER_ASLEEP] < 3) simulation.step();
    ReferenceBackend<float> whole(state);
    for (u32 i = 0; i < simulation.steps_done(); ++i) step(whole, params_of_step(state.params, i));
    for (u32 i = 0; i < 20; ++i) {
      simulation.step();
      step(whole, state.params);
      whole.run(Stage::hash_state, state.params);
      ASSERT_EQ(hash_of(simulation), combined_state_hash(whole.buffers().world_hashes)) << "step " << i;
    }
  }
}

// Where it reverses it is slow: for less than `after`, and for more.
TEST(Sleeping, APendulumDoesNotSleepWhereItReverses) {
  for (const char* after : {"0.1", "0.03"}) {
    Simulation<float> simulation = on_reference(compile<float>(
        scene_of(R"({"name": "bob", "mass": 1, "inertia": [0.1, 0.1, 0.1], "position": [1, 0, 5]})",
                 R"("sleeping": {"speed": 0.3, "angular_speed": 0.3, "after": )" + std::string(after) + "}",
                 R"(, "joints": [{"type": "ball", "bodies": ["world", "bob"], "anchor": [0, 0, 5]}])")));
    u32 reversals = 0, slow_steps = 0, longest = 0;
    for (u32 i = 0; i < 640; ++i) {
      simulation.step();
      const bool slow = is_slow(state_of(simulation).motions[1], 0.3f, 0.3f);
      reversals += slow && slow_steps == 0 ? 1 : 0;
      slow_steps = slow ? slow_steps + 1 : 0;
      longest = std::max(longest, slow_steps);
      ASSERT_FALSE(sleeps(simulation, 1)) << after << ", " << i;
    }
    EXPECT_GE(reversals, 8u);
    EXPECT_GE(longest, 3u);
    EXPECT_LT(longest, sleep_steps(0.1, 0.015625));
  }
}

// The order of colours has an end where bodies can sleep; nobody goes past it in silence.
TEST(Sleeping, HasColorRanksForSoManyContacts) {
  const u32 last = reference::color_sort_key_of_shapes(0, 0, max_color_ranks - 1) & ((1u << 26) - 1);
  EXPECT_EQ(last, max_color_ranks - 1);      // the rank is all there
  EXPECT_LT(63u << 26 | last, 0xfffffffeu);  // and a priority remains in the last class
  EXPECT_NO_THROW(expect_color_ranks_for(max_color_ranks, 7));
  try {
    expect_color_ranks_for(max_color_ranks + 1, 7);
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(
        error.what(),
        "step 7, color_contacts: 67108863 contacts, of which 67108862 have a place where bodies can sleep; run "
        "it with --sleeping off");
  }
}

// The floor of a lift, and a belt: what they carry stays awake while they move, however slowly.
TEST(Sleeping, WhatAKinematicBodyCarriesStaysAwakeWhileItMoves) {
  for (const char* velocity : {"[0, 0, 0.004]", "[0.004, 0, 0]"}) {
    const std::string lift = R"({"type": "kinematic", "position": [0, 0, 1], "velocity": )" + std::string(velocity) +
                             R"(, "shapes": [{"type": "box", "size": [4, 4, 1]}]})";
    Simulation<float> simulation = on_reference(compile<float>(scene_of(lift + ", " + box(0, 2))));
    for (u32 i = 0; i < 200; ++i) {
      simulation.step();
      ASSERT_FALSE(sleeps(simulation, 2)) << velocity << i;
    }
    // it stops: what it carries falls asleep, and wakes in the step in which it goes on
    const auto set_lift = [&](float x) {
      Buffers<float> buffers;
      buffers.motions = state_of(simulation).motions;
      buffers.motions[1].v[0] = x;
      buffers.motions[1].v[2] = 0;
      simulation.backend().upload(Buffer::motions, buffers);
    };
    set_lift(0);
    for (u32 i = 0; i <= 2 * steps_of_half_a_second; ++i) simulation.step();
    EXPECT_TRUE(sleeps(simulation, 2)) << velocity;
    set_lift(0.5f);
    simulation.step();
    EXPECT_FALSE(sleeps(simulation, 2)) << velocity;
    EXPECT_GT(state_of(simulation).motions[2].v[0], 0.01f) << velocity;
  }
}

TEST(Sleeping, ABallWakesTheIslandItHitsInThatStepAndNoOther) {
  const InitialState<float> state = compile<float>(scene_of(two_columns_and_a_ball));
  Simulation<float> simulation = on_reference(state);
  Simulation<float> awake =
      on_reference(compile<float>(scene_of(two_columns_and_a_ball, R"("sleeping": {"after": 1e9})")));
  while (simulation.wakings() == 0) {
    ASSERT_LT(simulation.steps_done(), 200u);
    simulation.step();
    awake.step();
    if (simulation.wakings() > 0) break;
    for (u32 body = 1; body <= 4 && simulation.steps_done() > 40; ++body)
      ASSERT_TRUE(sleeps(simulation, body)) << simulation.steps_done();
  }
  const double x = double(state_of(simulation).positions[5].x);
  EXPECT_GT(x, -1 - 6 * 0.015625 - 0.006);  // not a step too early
  for (u32 body = 1; body <= 2; ++body) EXPECT_FALSE(sleeps(simulation, body));
  for (u32 body = 3; body <= 4; ++body) EXPECT_TRUE(sleeps(simulation, body));
  // what a wall that never slept does: bodies sleep within 0.1 mm of where they would be, and are hit alike
  for (u32 i = 0; i < 20; ++i) {
    simulation.step();
    awake.step();
  }
  for (u32 body = 1; body <= 5; ++body) {
    const Vec4<float> is = state_of(simulation).positions[body], would = state_of(awake).positions[body];
    EXPECT_NEAR(is.x, would.x, 0.002) << body;
    EXPECT_NEAR(is.y, would.y, 0.002) << body;
    EXPECT_NEAR(is.z, would.z, 0.002) << body;
  }
  EXPECT_GT(state_of(simulation).positions[1].x, 0.1f);  // it was hit indeed
}

// A ball so light that it changes nothing, which wakes a column.
TEST(Sleeping, AStackThatWakesDoesNotJolt) {
  const std::string fly = R"({"mass": 1e-6, "position": [0, 0, 35], "shapes": [{"type": "sphere", "radius": 0.1}]})";
  for (const auto& [solver, boxes] : {std::pair("gauss_seidel", 3), {"small_steps", 5}, {"jacobi", 2}}) {
    const std::string settings = R"("sleeping": {"after": 0.25}, "solver": ")" + std::string(solver) + "\"";
    Simulation<float> simulation = on_reference(compile<float>(scene_of(column(0, boxes) + ", " + fly, settings)));
    while (simulation.wakings() == 0) {
      ASSERT_LT(simulation.steps_done(), 300u) << solver;
      simulation.step();
    }
    double fastest = 0;
    for (int body = 1; body <= boxes; ++body) {
      const Motion<float>& m = state_of(simulation).motions[std::size_t(body)];
      fastest = std::max({fastest, double(std::abs(m.v[0])), double(std::abs(m.v[1])), double(std::abs(m.v[2]))});
    }
    EXPECT_LT(fastest, 0.02) << solver;  // gravity alone gives 0.15 m/s in a step
  }
}

TEST(Sleeping, NothingBeginsOrCeasesToTouchBySleepOrByWaking) {
  Simulation<float> simulation =
      on_reference(compile<float>(scene_of(two_columns_and_a_ball, R"("events": true, "sleeping": {"after": 0.5})")));
  simulation.step();
  EXPECT_FALSE(simulation.events().empty());
  std::vector<Event> events;
  for (u32 awake = 0; awake < 3; awake += simulation.wakings()) {
    simulation.step();
    for (const Event& event : simulation.events()) events.push_back(event);
  }
  // the ball, which rolls, and the floor; and at the impact, soon after what it can reach has woken, the first box
  u32 hits = 0;
  for (const Event& event : events) {
    EXPECT_EQ(std::max(event.body_a, event.body_b), 5u) << event.step;
    if (std::min(event.body_a, event.body_b) == 0) continue;
    EXPECT_EQ(event.kind, u32(EVENT_CONTACT_BEGIN));
    EXPECT_EQ(event.body_a, 1u);
    ++hits;
  }
  EXPECT_EQ(hits, 1u);
}

TEST(Sleeping, ATriggerGoesOnDetectingWhatSleeps) {
  const std::string gate = R"({"type": "static", "position": [0, 0, 0.5], "shapes": [
    {"type": "box", "size": [3, 3, 3], "trigger": true}]})";
  Simulation<float> simulation = on_reference(compile<float>(scene_of(gate + ", " + box(0, 0.5))));
  u32 enters = 0, leaves = 0;
  for (u32 i = 0; i < 60; ++i) {
    simulation.step();
    for (const Event& event : simulation.events()) {
      enters += event.kind == EVENT_TRIGGER_ENTER ? 1 : 0;
      leaves += event.kind == EVENT_TRIGGER_LEAVE ? 1 : 0;
    }
  }
  EXPECT_TRUE(sleeps(simulation, 2));
  EXPECT_EQ(enters, 1u);
  EXPECT_EQ(leaves, 0u);
  EXPECT_EQ(state_of(simulation).sleepers.size(), 3u);
}

// A row of three hangs between two joints to the world: held apart by nothing but joints, it sleeps as one.
TEST(Sleeping, WhatJointsConnectIsOneIslandAndKeepsItsImpulses) {
  std::string bodies, joints = R"(, "joints": [)";
  for (int i = 0; i < 3; ++i) {
    const std::string name = "link_" + std::to_string(i);
    bodies += (i > 0 ? ", " : "") + std::string(R"({"name": ")") + name +
              R"(", "mass": 1, "inertia": [0.1, 0.1, 0.1], "position": [0, 0, )" + std::to_string(5 - i) + "]}";
    const std::string above = i > 0 ? "link_" + std::to_string(i - 1) : "world";
    joints += std::string(i > 0 ? ", " : "") + R"({"type": "hinge", "axis": [0, 1, 0], "bodies": [")" + above +
              R"(", ")" + name + R"("], "anchor": [0, 0, )" + std::to_string(5.5 - i) + "]}";
  }
  for (const char* solver : {"gauss_seidel", "small_steps"}) {
    const std::string settings = R"("sleeping": {"after": 0.5}, "solver": ")" + std::string(solver) + "\"";
    Simulation<float> simulation = on_reference(compile<float>(scene_of(bodies, settings, joints + "]")));
    while (simulation.counters()[COUNTER_ASLEEP] == 0) {
      ASSERT_LT(simulation.steps_done(), 300u) << solver;
      simulation.step();
    }
    ASSERT_EQ(simulation.counters()[COUNTER_ASLEEP], 3u) << solver;
    EXPECT_EQ(simulation.counters()[COUNTER_ISLANDS], 1u) << solver;
    const Buffer wanted[] = {Buffer::joint_impulses, Buffer::sleepers};
    const Buffers<float> before = simulation.backend().download(wanted);
    for (u32 i = 0; i < 10; ++i) lockstep::step(simulation.backend(), simulation.params());
    const Buffers<float> after = simulation.backend().download(wanted);
    double carried = 0;
    for (u32 row = 0; row < JOINT_ROWS; ++row)
      for (u32 lane = 0; lane < 3; ++lane) {
        for (std::size_t b = 0; b < before.joint_impulses.size(); ++b) {
          EXPECT_EQ(before.joint_impulses[b].locked[row][lane], after.joint_impulses[b].locked[row][lane]);
          carried += std::abs(double(before.joint_impulses[b].locked[row][lane]));
        }
      }
    EXPECT_GT(carried, 0.1) << solver;
    // woken, it hangs as it did
    Buffers<float> woken;
    woken.sleepers = after.sleepers;
    for (Sleeper& sleeper : woken.sleepers) sleeper = {0, sleeper.island == NONE ? NONE : ISLAND_WAKES};
    simulation.backend().upload(Buffer::sleepers, woken);
    simulation.step();
    for (u32 body = 1; body <= 3; ++body) {
      EXPECT_FALSE(sleeps(simulation, body));
      EXPECT_LT(std::abs(state_of(simulation).motions[body].v[2]), 0.01f) << solver;
    }
  }
}

}  // namespace
}  // namespace lockstep::test::sleeping_test
