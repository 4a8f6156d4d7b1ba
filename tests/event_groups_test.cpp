// What events are of: shapes, bodies, or triangles of surfaces.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "host/scene/surface.hpp"
#include "tests/library_worlds.hpp"
#include "tests/sleeping_scenes.hpp"

namespace lockstep::test::event_groups_test {
namespace {

struct Run {
  const char *solver, *pairs;
  u32 substeps = 1;
};

// A ball that slides and rolls over a grid of 6 by 2 cells without a break, and never leaves it.
Scene ball_on_a_grid(const Run& run, const std::string& more = "") {
  const std::string row = "[0, 0, 0, 0, 0, 0, 0]";
  return parse_scene(R"({"settings": {"events": true, "event_pairs": ")" + std::string(run.pairs) +
                         R"(", "solver": ")" + run.solver + R"(", "substeps": )" + std::to_string(run.substeps) +
                         R"(}, "bodies": [{"type": "static", "shapes": [{"type": "height_field", "spacing": 1,
                      "heights": [)" +
                         row + ", " + row + ", " + row + R"(]}]},
                      {"mass": 1, "position": [-2.5, 0.06, 0.1], "velocity": [2, 0, 0], "angular_velocity": [0, 20, 0],
                       "shapes": [{"type": "sphere", "radius": 0.1}]})" +
                         more + "]}",
                     "x.json");
}

template <class real>
std::vector<PairEvent> events_of(const Scene& scene, u32 steps) {
  Simulation<real> simulation = on_reference(compile<real>(scene));
  const EventGroups groups({&scene, 1});
  std::vector<PairEvent> all;
  for (u32 i = 0; i < steps; ++i) {
    simulation.step();
    for (const PairEvent& event : simulation.events(groups)) all.push_back(event);
  }
  return all;
}

template <class real>
void expect_one_begin_on_a_grid() {
  for (const char* pairs : {"shapes", "bodies"}) {
    for (const char* solver : {"small_steps", "gauss_seidel"}) {
      for (const u32 substeps : {1u, 4u}) {
        const std::vector<PairEvent> events = events_of<real>(ball_on_a_grid({solver, pairs, substeps}), 100);
        ASSERT_EQ(events.size(), 1u) << pairs << ", " << solver << ", " << substeps;
        EXPECT_EQ(events[0].kind, EVENT_CONTACT_BEGIN);
        EXPECT_EQ(events[0].a, (EventSide{0, 0}));
        EXPECT_EQ(events[0].b, (EventSide{1, 0}));
      }
    }
  }
}

TEST(EventGroups, ABallThatRollsOverAHeightFieldBeginsOnceInFloat) { expect_one_begin_on_a_grid<float>(); }
TEST(EventGroups, ABallThatRollsOverAHeightFieldBeginsOnceInDouble) { expect_one_begin_on_a_grid<double>(); }

// Along y = 0.06 it crosses the upper triangles' row: each one is entered, and left but for the last.
TEST(EventGroups, TrianglesBeginAndEndByThemselvesWhereAskedFor) {
  const std::vector<PairEvent> events = events_of<double>(ball_on_a_grid({"gauss_seidel", "triangles"}), 100);
  std::set<u32> triangles;
  int touching = 0;
  for (const PairEvent& event : events) {
    triangles.insert(event.a.triangle);
    EXPECT_EQ(event.b.triangle, NONE);
    touching += event.kind == EVENT_CONTACT_BEGIN ? 1 : -1;
  }
  EXPECT_GE(triangles.size(), 4u);  // 3 m are at least three cells' worth of them
  EXPECT_EQ(triangles.count(NONE), 0u);
  EXPECT_EQ(touching, 1);
}

// A body of two balls side by side that lands on both: two pairs of shapes, one of bodies.
TEST(EventGroups, BodiesOfSeveralShapesBeginOnceWhereAskedFor) {
  const std::string dumbbell = R"({"mass": 1, "position": [0, 0, 0.5], "shapes": [
    {"type": "sphere", "radius": 0.2, "offset": [-0.5, 0, 0]}, {"type": "sphere", "radius": 0.2, "offset": [0.5, 0, 0]}]})";
  for (const auto& [pairs, count] : {std::pair{"shapes", 2u}, {"bodies", 1u}}) {
    const std::string settings = R"("events": true, "event_pairs": ")" + std::string(pairs) + "\"";
    const std::vector<PairEvent> events = events_of<float>(scene_of(dumbbell, settings), 60);
    ASSERT_EQ(events.size(), count) << pairs;
    EXPECT_EQ(events[0].a.shape, 0u);  // the body's own index; the plane is side b
    EXPECT_EQ(events[0].b, (EventSide{0, 0}));
    EXPECT_EQ(events.back().a.shape, count - 1);
  }
}

// A body of two boxes, each many particles, falls on the ground: its shapes are those of its description.
TEST(EventGroups, ParticlesThatAreShapesAreOfTheirShapes) {
  for (const char* pairs : {"shapes", "bodies"}) {
    Scene scene = parse_scene(R"({"particles": {"radius": 0.1, "model": "constraints"},
      "settings": {"events": true, "event_pairs": ")" +
                                  std::string(pairs) + R"("}, "bodies": [
      {"mass": 1, "position": [0, 0, 0.42], "shapes": [{"type": "box", "size": [0.8, 0.8, 0.8]}]},
      {"mass": 1, "position": [5, 0, 0.42], "shapes": [{"type": "box", "size": [0.8, 0.8, 0.8], "offset": [-1, 0, 0]},
                                                       {"type": "box", "size": [0.8, 0.8, 0.8], "offset": [1, 0, 0]}]},
      {"type": "static", "shapes": [{"type": "plane"}]}]})",
                              "x.json");
    std::set<std::pair<u32, u32>> begun;
    for (const PairEvent& event : events_of<double>(scene, 30)) {
      EXPECT_EQ(event.kind, EVENT_CONTACT_BEGIN);
      EXPECT_EQ(event.b, (EventSide{2, 0}));
      EXPECT_TRUE(begun.insert({event.a.body, event.a.shape}).second) << "each begins once";
    }
    EXPECT_EQ(begun.size(), pairs == std::string("bodies") ? 2u : 3u);
  }
}

// Off the edge of the grid: it begins once and ends once.
TEST(EventGroups, ABallThatRollsOffAHeightFieldEndsOnce) {
  const std::vector<PairEvent> events = events_of<double>(ball_on_a_grid({"gauss_seidel", "shapes"}), 220);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[1].kind, EVENT_CONTACT_END);
  EXPECT_NEAR(events[1].step / 60.0, 5.6 / 2, 0.1);  // 5.5 m at 2 m/s, and around the edge
}

TEST(EventGroups, DeviceAndReferenceTellTheSame) {
  const Scene scene = ball_on_a_grid({"small_steps", "shapes", 4});
  const InitialState<float> state = compile<float>(scene);
  const EventGroups groups({&scene, 1});
  Simulation<float> one = on_reference(state), other = on_device(state);
  for (u32 i = 0; i < 60; ++i) {
    one.step();
    other.step();
    const std::vector<PairEvent> expected = one.events(groups), events = other.events(groups);
    ASSERT_EQ(events.size(), expected.size()) << i;
    for (u32 k = 0; k < events.size(); ++k) EXPECT_EQ(events[k].kind, expected[k].kind);
  }
}

// Sets of pairs before and after a step, by hand: simulated shapes 0 and 1 are triangles of one surface, 2 is a ball.
TEST(EventGroups, APairChangesWhereItsFirstTriangleIsTouchedOrItsLastOneLeft) {
  Scene scene = ball_on_a_grid({"gauss_seidel", "shapes"});
  const EventGroups groups({&scene, 1});
  const u32 ball = static_cast<u32>(simulated_shapes(scene.bodies[0]));
  const auto event = [&](EventKind kind, u32 triangle) { return Event{kind, 0, 0, 0, triangle, 1, ball, 0}; };
  const auto count = [&](std::vector<Event> events, std::vector<Pair> touching) {
    return groups.merge(events, touching).size();
  };
  EXPECT_EQ(count({event(EVENT_CONTACT_BEGIN, 0)}, {{0, ball}}), 1u);
  EXPECT_EQ(count({event(EVENT_CONTACT_BEGIN, 0), event(EVENT_CONTACT_BEGIN, 1)}, {{0, ball}, {1, ball}}), 1u);
  EXPECT_EQ(count({event(EVENT_CONTACT_BEGIN, 1)}, {{0, ball}, {1, ball}}), 0u);
  EXPECT_EQ(count({event(EVENT_CONTACT_END, 0), event(EVENT_CONTACT_BEGIN, 1)}, {{1, ball}}), 0u);
  EXPECT_EQ(count({event(EVENT_CONTACT_END, 0)}, {{1, ball}}), 0u);
  EXPECT_EQ(count({event(EVENT_CONTACT_END, 0), event(EVENT_CONTACT_END, 1)}, {}), 1u);
  EXPECT_EQ(count({event(EVENT_CONTACT_END, 0)}, {}), 1u);
}

// ---- in a world

std::vector<BodyEvent> next_events(World& world) {
  world.step();
  return {world.events().begin(), world.events().end()};
}

World world_with_two_boxes(std::vector<BodyHandle>& boxes, const std::string& device = "reference") {
  Scene scene = ground_scene();
  scene.settings.events = true;
  World world(scene, {.device = device, .precision = "double"});
  for (const double x : {0.0, 5.0}) boxes.push_back(world.add(box_at({x, 0, 0.5})));
  world.step(10);
  return world;
}

TEST(EventGroups, WhatIsRemovedEndsWhatItTouched) {
  std::vector<BodyHandle> boxes;
  World world = world_with_two_boxes(boxes);
  world.remove(boxes[0]);
  world.pose(boxes[1]);  // a question in between tells nothing
  const std::vector<BodyEvent> events = next_events(world);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EVENT_CONTACT_END);
  EXPECT_EQ(events[0].a, boxes[0]);
  EXPECT_EQ(events[0].b, *world.find("floor"));
  EXPECT_TRUE(next_events(world).empty());
}

TEST(EventGroups, WhatIsTeleportedEndsWhatItTouchedAndMayBeginAnew) {
  std::vector<BodyHandle> boxes;
  World world = world_with_two_boxes(boxes);
  world.teleport(boxes[1], {.position = {0, 0, 50}});
  std::vector<BodyEvent> events = next_events(world);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EVENT_CONTACT_END);
  EXPECT_EQ(events[0].a, boxes[1]);
  world.teleport(boxes[0], {.position = {3, 0, 0.5}});
  events = next_events(world);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].kind, EVENT_CONTACT_END);
  EXPECT_EQ(events[1].kind, EVENT_CONTACT_BEGIN);
  EXPECT_EQ(events[0].a, boxes[0]);
  EXPECT_EQ(events[1].a, boxes[0]);
}

TEST(EventGroups, WhatIsRemovedInATriggerLeavesIt) {
  Scene scene = ground_scene();
  World world(scene, in_double());
  BodyDescription gate = box_at({0, 0, 0.5});
  gate.kind = BODY_STATIC, gate.mass = 0, gate.inertia = {0, 0, 0};
  gate.shapes[0].trigger = true;
  const BodyHandle trigger = world.add(gate), box = world.add(box_at({0, 0, 0.5}));
  world.step(5);
  world.remove(box);
  const std::vector<BodyEvent> events = next_events(world);
  ASSERT_EQ(events.size(), 2u);
  for (const BodyEvent& event : events) {
    EXPECT_EQ(event.kind, event.a == trigger ? EVENT_TRIGGER_LEAVE : EVENT_CONTACT_END);
    EXPECT_EQ(event.a == trigger ? event.b : event.a, box);
  }
}

// A joint lets its bodies pass through each other.
TEST(EventGroups, WhatAJointTakesOverEnds) {
  std::vector<BodyHandle> boxes;
  World world = world_with_two_boxes(boxes);
  const BodyHandle upper = world.add(box_at({0, 0, 1.5}));
  world.step(10);
  world.add(JointDescription{.kind = JOINT_FIXED, .anchor_a = {0, 0, 1}}, boxes[0], upper);
  const std::vector<BodyEvent> events = next_events(world);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EVENT_CONTACT_END);
  EXPECT_EQ((std::set<u32>{events[0].a.id, events[0].b.id}), (std::set<u32>{boxes[0].id, upper.id}));
}

}  // namespace
}  // namespace lockstep::test::event_groups_test
