// Events of impacts: how fast two came together, and what their contacts gave.
#include <cmath>

#include "tests/command_line.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::impact_events_test {
namespace {

constexpr double g = 9.81;

Scene scene_with(double impact_speed, double restitution = 0) {
  Scene scene = ground_scene();
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.dt = 0.001;
  scene.settings.impact_speed = impact_speed;
  scene.materials[0].restitution = restitution;
  return scene;
}

std::vector<BodyEvent> impacts_in(World& world, u32 steps) {
  std::vector<BodyEvent> impacts;
  for (u32 i = 0; i < steps; ++i) {
    world.step();
    for (const BodyEvent& event : world.events()) {
      EXPECT_EQ(event.impact.has_value(), event.kind == EVENT_IMPACT);
      if (event.impact) impacts.push_back(event);
    }
  }
  return impacts;
}

// 1 m deep, then at half the speed 1/4 m high, and so on: v, v/2, v/4 ... until the bound.
TEST(ImpactEvents, ABallThatBouncesTellsItsSpeeds) {
  for (const char* device : {"reference", "auto"}) {
    World world(scene_with(1, 0.5), {.device = device, .precision = "double"});
    const BodyHandle floor = *world.find("floor"), ball = world.add(ball_at({0, 0, 1.5}));
    const std::vector<BodyEvent> impacts = impacts_in(world, 3000);
    ASSERT_EQ(impacts.size(), 3u);
    double speed = std::sqrt(2 * g);
    const double mass = world.description(ball).mass;
    for (const BodyEvent& event : impacts) {
      EXPECT_EQ(event.a, ball);
      EXPECT_EQ(event.b, floor);
      EXPECT_NEAR(event.impact->speed, speed, 0.01 * speed);
      EXPECT_NEAR(event.impact->impulse[2], 1.5 * mass * event.impact->speed, 0.02 * mass);
      EXPECT_EQ(event.impact->normal, (Vector3{0, 0, 1}));
      EXPECT_NEAR(event.impact->point[2], 0, 0.01);
      speed /= 2;
    }
  }
}

// What does not bounce is stopped in two sub-steps: it is told once, in the first. And a box that tips over hits with
// its other edge though it has touched all along: it falls by 45 degrees about one edge, w^2 = 2 m g h / I about that.
TEST(ImpactEvents, TellABlowOnceAndAnotherOneOfThoseThatTouchAgain) {
  Scene scene = scene_with(1);
  scene.gravity = {0, 0, -g};
  World world(scene, in_double());
  const BodyHandle ball = world.add(ball_at({9, 0, 1.5}));
  BodyDescription box = box_at({0, 0, 0.5 * std::sqrt(2.0)});
  const double half = 0.5 * (exact::pi / 4 + 1e-3);
  box.orientation = {0, std::sin(half), 0, std::cos(half)};
  const BodyHandle tips = world.add(box);
  u32 of_ball = 0, of_box = 0;
  for (const BodyEvent& event : impacts_in(world, 4000)) {
    (event.a == ball ? of_ball : of_box) += 1;
    if (event.a != tips) continue;
    const double height = 0.5 * (std::sqrt(2.0) - 1), moment = 2.0 / 3;  // about an edge, by its mass
    EXPECT_NEAR(event.impact->speed, std::sqrt(2 * g * height / moment), 0.1);
  }
  EXPECT_EQ(of_ball, 1u);
  EXPECT_EQ(of_box, 1u);
}

// A body that comes to rest within a step of many sub-steps was as fast.
TEST(ImpactEvents, SubStepsTellTheSpeedToo) {
  Scene scene = ground_scene();
  scene.settings.dt = 0.02;
  scene.settings.impact_speed = 0.5;
  World world(scene, in_double());
  world.add(ball_at({0, 0, 1.5}));
  const std::vector<BodyEvent> impacts = impacts_in(world, 200);
  ASSERT_EQ(impacts.size(), 1u) << "what rests is no impact";
  EXPECT_NEAR(impacts[0].impact->speed, std::sqrt(2 * g), 0.05);
}

// Two balls of masses m and 2 m head on: e = 1/2, J = (1 + e) v m 2m / 3m.
TEST(ImpactEvents, BallsThatMeetTellTheirImpulse) {
  Scene scene = scene_with(0.1, 0.5);
  scene.gravity = {0, 0, 0};
  scene.bodies.clear();
  World world(scene, in_double());
  BodyDescription heavy = ball_at({2, 0, 0});
  make_solid_of_mass(heavy, 2);
  heavy.velocity = {-2, 0, 0};
  BodyDescription light = ball_at({0, 0, 0});
  make_solid_of_mass(light, 1);
  light.velocity = {1, 0, 0};
  const BodyHandle one = world.add(light), other = world.add(heavy);
  const std::vector<BodyEvent> impacts = impacts_in(world, 1000);
  ASSERT_EQ(impacts.size(), 1u);
  const Impact& impact = *impacts[0].impact;
  EXPECT_EQ(impacts[0].a, one);
  EXPECT_EQ(impacts[0].b, other);
  EXPECT_NEAR(impact.speed, 3, 1e-12);
  EXPECT_NEAR(impact.impulse[0], -1.5 * 3 * 2 / 3, 1e-9);
  EXPECT_NEAR(impact.normal[0], -1, 1e-12);
  EXPECT_NEAR(impact.point[0], 0.5 + 1.0 / 3, 5e-3);
}

// A box that lands flat has four points, which are one impact: of (1 + e) m v with e = 1/2.
TEST(ImpactEvents, AreOfPairsAsOtherEventsAre) {
  for (const EventPairs pairs : {EventPairs::shapes, EventPairs::bodies}) {
    Scene scene = scene_with(1, 0.5);
    scene.settings.event_pairs = pairs;
    World world(scene, in_double());
    BodyDescription box = box_at({0, 0, 1}, 3);
    BodyDescription twins = box_at({5, 0, 1}, 3);
    twins.shapes.push_back(twins.shapes[0]);
    const BodyHandle one = world.add(box), two = world.add(twins);
    double of_one = 0, of_two = 0;
    u32 count = 0;
    for (const BodyEvent& event : impacts_in(world, 400)) {
      EXPECT_NEAR(event.impact->speed, std::sqrt(2 * g * 0.5), 0.02);
      (event.a == one ? of_one : of_two) += event.impact->impulse[2];
      EXPECT_TRUE(event.a == one || event.a == two);
      ++count;
    }
    EXPECT_EQ(count, pairs == EventPairs::bodies ? 2u : 3u);
    const double momentum = 1.5 * 3 * std::sqrt(2 * g * 0.5);
    EXPECT_NEAR(of_one, momentum, 0.02 * momentum);
    EXPECT_NEAR(of_two, momentum, 0.02 * momentum);
  }
}

// A body on a moving platform that hits it from below.
TEST(ImpactEvents, KnowHowFastKinematicBodiesAre) {
  Scene scene = scene_with(1);
  scene.gravity = {0, 0, 0};
  World world(scene, in_double());
  BodyDescription bat = box_at({0, 0, 3});
  bat.kind = BODY_KINEMATIC, bat.mass = 0, bat.inertia = {0, 0, 0};
  bat.velocity = {0, 0, 4};
  const BodyHandle hits = world.add(bat), ball = world.add(ball_at({0, 0, 5}));
  const std::vector<BodyEvent> impacts = impacts_in(world, 500);
  ASSERT_EQ(impacts.size(), 1u);
  EXPECT_NEAR(impacts[0].impact->speed, 4, 1e-12);
  EXPECT_TRUE((impacts[0].a == ball && impacts[0].b == hits) || (impacts[0].a == hits && impacts[0].b == ball));
}

TEST(ImpactEvents, AreTheSameEverywhereAndGoneBackTo) {
  for (const char* precision : {"float", "double"}) {
    std::vector<double> told[2];
    for (const char* device : {"reference", "auto"}) {
      Scene scene = ground_scene();
      scene.settings.impact_speed = 0.2;
      World world(scene, {.device = device, .precision = precision});
      for (int i = 0; i < 5; ++i)
        world.add(i % 2 ? box_at({0.1 * i, 0, 1.0 + 1.2 * i}) : ball_at({0.1 * i, 0.05, 1.0 + 1.2 * i}));
      std::vector<double>& all = told[std::string(device) == "auto"];
      for (int i = 0; i < 150; ++i) {
        world.step();
        const Snapshot snapshot = world.save();
        if (i % 10 == 0) world.step();
        if (i % 10 == 0) world.restore(snapshot);
        for (const BodyEvent& event : world.events()) {
          if (!event.impact) continue;
          const Impact& impact = *event.impact;
          all.insert(all.end(), {double(i), impact.speed, impact.point[0], impact.normal[2], impact.impulse[2]});
        }
      }
    }
    EXPECT_GT(told[0].size(), 25u);
    EXPECT_EQ(told[0], told[1]);
  }
}

// Asking for impacts changes no bit, and a scene that does not has none.
TEST(ImpactEvents, ChangeNothing) {
  Scene scene = ground_scene();
  scene.settings.events = true;
  World without(scene, in_double());
  scene.settings.impact_speed = 0;
  World with(scene, in_double());
  for (World* world : {&without, &with}) {
    world->add(ball_at({0, 0, 0.9}));
    world->add(box_at({0.1, 0, 2}));
  }
  EXPECT_TRUE(impacts_in(without, 100).empty());
  EXPECT_FALSE(impacts_in(with, 100).empty());
  EXPECT_EQ(with.state_hash(), without.state_hash());
}

using ImpactEventsWritten = CommandLine;

TEST_F(ImpactEventsWritten, HaveTheirSpeedInALine) {
  std::ofstream(file("drop.json")) << R"({"bodies": [{"type": "static", "shapes": [{"type": "plane"}]},
    {"name": "ball", "mass": 1, "position": [0, 0, 1.5], "shapes": [{"type": "sphere", "radius": 0.5}]}]})";
  const std::string report = file("report.json").string(), events = file("events.jsonl").string();
  const Outcome outcome =
      run("run " + file("drop.json").string() + " --device reference --steps 60 --impact-speed 2 --events " + events +
          " --report " + report);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("impacts: 1"), std::string::npos) << outcome.out;
  const std::string lines = read_file(events);
  const std::size_t at = lines.find("\"event\":\"impact\"");
  ASSERT_NE(at, std::string::npos) << lines;
  EXPECT_NE(lines.find("\"speed\":4.25", at), std::string::npos) << "26 steps of g / 60: " << lines;
  EXPECT_NE(read_file(report).find("\"impacts\": 1"), std::string::npos);
}

}  // namespace
}  // namespace lockstep::impact_events_test
