// What changes while a world runs disturbs nobody else, wakes and tells whom it concerns, and is the same everywhere.
#include "host/record/replay.hpp"
#include "tests/library_worlds.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::world_changes_bits_test {
namespace {

JointDescription hinge_at(const Vector3& anchor) {
  return {.name = "hinge", .kind = JOINT_HINGE, .anchor_a = anchor, .anchor_b = anchor, .axis = {0, 1, 0}};
}

// A stack, and apart from it a box of its own material that swings above a ball.
struct Yard {
  World world;
  BodyHandle low, high, box, ball;
  JointHandle hinge;

  static Scene scene() {
    Scene scene = ground_scene();
    scene.settings.events = true;
    scene.materials.push_back({.name = "other", .friction = 0.5});
    return scene;
  }

  explicit Yard(const WorldOptions& options, const Scene& of = scene())
      : world(of, options),
        low(world.add(box_at({0, 0.1, 0.5}))),
        high(world.add(box_at({0.1, 0, 1.5}))),
        box(world.add(of_other(box_at({9, 0, 2})))),
        ball(world.add(of_other(ball_at({10, 0, 0.5})))),
        hinge(world.add(hinge_at({8.5, 0, 2.5}), box)) {}

  static BodyDescription of_other(BodyDescription body) {
    body.shapes[0].material = 1;
    return body;
  }

  BodyDescription heavier() const {
    BodyDescription body = world.description(box);
    body.mass *= 2;
    for (double& moment : body.inertia) moment *= 2;
    return body;
  }
  BodyDescription longer() const {
    BodyDescription body = world.description(box);
    body.shapes[0].half_extents = {0.5, 0.5, 0.8};
    body.shapes.push_back({.kind = SHAPE_CYLINDER, .radius = 0.2, .half_length = 0.4});
    return body;
  }
  BodyDescription fixed() const {
    BodyDescription body = world.description(ball);
    body.kind = BODY_STATIC, body.mass = 0, body.inertia = {0, 0, 0};
    return body;
  }
  JointDescription braked() const {
    JointDescription joint = world.description(hinge);
    joint.friction = 3;
    return joint;
  }
};

void expect_same_stack(Yard& a, Yard& b) {
  for (const auto& [one, other] : {std::pair(a.low, b.low), {a.high, b.high}}) {
    EXPECT_EQ(a.world.pose(one).position, b.world.pose(other).position);
    EXPECT_EQ(a.world.pose(one).orientation, b.world.pose(other).orientation);
    EXPECT_EQ(a.world.velocity(one).linear, b.world.velocity(other).linear);
  }
}

TEST(WorldChangesBits, AStackBesideThemKeepsEveryBit) {
  for (const char* precision : {"float", "double"}) {
    const WorldOptions options = {.device = "reference", .precision = precision};
    Yard still(options), yard(options);
    World& world = yard.world;
    for (int step = 0; step < 60; ++step) {
      if (step == 10) world.change(yard.box, yard.heavier());
      if (step == 20) world.change(yard.box, yard.longer());
      if (step == 25) world.change(yard.hinge, yard.braked());
      if (step == 30) world.set_material(1, {.friction = 0.1, .restitution = 0.5});
      if (step == 35) world.set_material_pair({.material_a = 1, .material_b = 1, .friction = 0, .restitution = 0});
      if (step == 40) world.change(yard.ball, yard.fixed());
      if (step == 45) world.set_speed_limit(1000);
      still.world.step();
      world.step();
      expect_same_stack(still, yard);
    }
    EXPECT_NE(still.world.pose(still.box).position, world.pose(yard.box).position);
  }
}

// Warm impulses, who touches, and poses: a change to what is there already is none.
TEST(WorldChangesBits, WhatChangesToWhatItWasChangesNothing) {
  for (const char* device : {"reference", "auto"}) {
    for (const char* precision : {"float", "double"}) {
      Yard untouched({.device = device, .precision = precision}), yard({.device = device, .precision = precision});
      World& world = yard.world;
      for (int step = 0; step < 40; ++step) {
        if (step == 20) {
          for (const BodyHandle body : world.bodies()) world.change(body, world.description(body));
          world.change(yard.hinge, world.description(yard.hinge));
          world.set_material(1, world.materials()[1]);
          world.set_gravity(world.gravity());
          world.set_speed_limit(world.speed_limit());
        }
        untouched.world.step();
        world.step();
        EXPECT_EQ(world.state_hash(), untouched.world.state_hash()) << step;
        EXPECT_EQ(world.events().size(), untouched.world.events().size()) << step;
      }
    }
  }
}

// ---- the same everywhere, and again

void change_in(Yard& yard, u32 step) {
  World& world = yard.world;
  if (step == 5) world.set_gravity({0.5, 0, -12});
  if (step == 8) world.change(yard.box, yard.heavier());
  if (step == 9) world.set_gravity({0, 0, -9});
  if (step == 12) world.change(yard.box, yard.longer()), world.change(yard.hinge, yard.braked());
  if (step == 16) world.set_material(1, {.friction = 0.1, .restitution = 0.5});
  if (step == 17) world.set_material_pair({.material_a = 0, .material_b = 1, .friction = 2, .restitution = 0.1});
  if (step == 20) world.change(yard.ball, yard.fixed());
  if (step == 24) world.set_speed_limit(1000);
  if (step == 26) world.change(yard.ball, Yard::of_other(ball_at({0, 0, 0})));
}

std::vector<std::uint64_t> life(const WorldOptions& options, const std::string& path) {
  Yard yard(options);
  if (!path.empty()) yard.world.record(path);
  std::vector<std::uint64_t> hashes;
  for (u32 step = 0; step < 40; ++step) {
    change_in(yard, step);
    yard.world.step();
    hashes.push_back(yard.world.state_hash());
  }
  return hashes;
}

class WorldChangesRecorded : public testing::Test {
 protected:
  std::string file(int number) const {
    return folder_.file(number == 1 ? "run.h5" : "run." + std::to_string(number) + ".h5");
  }

  template <class real>
  void expect_replays(const StepTarget& target) const {
    u32 steps = 0;
    for (const int number : {1, 2, 3, 4, 5, 6, 7, 8, 9}) {
      SCOPED_TRACE(number);
      ASSERT_EQ(std::filesystem::exists(file(number)), number < 9);
      if (number < 9) replay<real>(RecordingReader(file(number)), target, [&](u32) { ++steps; });
    }
    EXPECT_EQ(steps, 40u);
  }

  const TemporaryFolder folder_;
};

TEST_F(WorldChangesRecorded, HaveTheSameBitsOnTheDeviceAndInReplaysInFloat) {
  const std::vector<std::uint64_t> hashes = life({.device = "reference", .precision = "float"}, file(1));
  expect_replays<float>({select_device("cpu"), {}});
  EXPECT_EQ(life({.device = "cpu", .precision = "float"}, file(1)), hashes);
  expect_replays<float>({});
}

TEST_F(WorldChangesRecorded, HaveTheSameBitsOnTheDeviceAndInReplaysInDouble) {
  const std::vector<std::uint64_t> hashes = life({.device = "reference", .precision = "double"}, file(1));
  expect_replays<double>({select_device("cpu"), {}});
  EXPECT_EQ(life({.device = "cpu", .precision = "double"}, ""), hashes);
}

TEST(WorldChangesBits, SnapshotsGoBackOverThemAndForth) {
  for (const char* device : {"reference", "auto"}) {
    Yard yard({.device = device, .precision = "float"});
    World& world = yard.world;
    std::vector<Snapshot> kept;
    std::vector<std::uint64_t> hashes;
    const auto step = [&](u32 i) {
      change_in(yard, i);
      world.step();
      return world.state_hash();
    };
    for (u32 i = 0; i < 40; ++i) {
      kept.push_back(world.save());
      hashes.push_back(step(i));
    }
    for (const u32 from : {0u, 30u, 6u, 16u, 21u}) {
      world.restore(kept[from]);
      for (u32 i = from; i < 40; ++i) ASSERT_EQ(step(i), hashes[i]) << from << ", " << i;
    }
    world.restore(kept[0]);
    EXPECT_EQ(world.gravity(), (Vector3{0, 0, -9.81}));
    EXPECT_EQ(world.speed_limit(), 1e5);
    EXPECT_EQ(world.description(yard.ball).kind, BODY_DYNAMIC);
  }
}

// A snapshot that waits for gravity to be set has it set.
TEST(WorldChangesBits, ASnapshotKnowsTheGravityOfTheNextStep) {
  Yard yard(in_double());
  yard.world.step(5);
  yard.world.set_gravity({0, 0, -1});
  const Snapshot snapshot = yard.world.save();
  yard.world.step();
  const std::uint64_t hash = yard.world.state_hash();
  yard.world.set_gravity({0, 0, -2});
  yard.world.step(3);
  yard.world.restore(snapshot);
  yard.world.step();
  EXPECT_EQ(yard.world.state_hash(), hash);
}

// ---- sleep

struct Sleepers {
  Yard yard;
  World& world = yard.world;

  static Scene sleepy() {
    Scene scene = Yard::scene();
    scene.settings.sleeping = SleepSettings{.after = 0.2};
    return scene;
  }

  explicit Sleepers(const WorldOptions& options = in_double()) : yard(options, sleepy()) {
    world.change(yard.hinge, yard.braked());
    world.step(400);
    expect_asleep(true, true, true);
  }

  void expect_asleep(bool stack, bool box, bool ball) {
    EXPECT_EQ(world.is_asleep(yard.low), stack);
    EXPECT_EQ(world.is_asleep(yard.high), stack);
    EXPECT_EQ(world.is_asleep(yard.box), box);
    EXPECT_EQ(world.is_asleep(yard.ball), ball);
  }
};

TEST(WorldChangesBits, WakeWhomTheyConcern) {
  struct Deed {
    const char* what;
    std::function<void(Yard&)> act;
    bool stack, box, ball;  // who sleeps after it
  };
  const Deed deeds[] = {
      {"gravity",
       [](Yard& y) {
         y.world.set_gravity({0, 0, -9});
       },
       false, false, false},
      {"the same gravity",
       [](Yard& y) {
         y.world.set_gravity({0, 0, -9.81});
       },
       true, true, true},
      {"a body", [](Yard& y) { y.world.change(y.low, y.world.description(y.low)); }, false, true, true},
      {"a body at a joint", [](Yard& y) { y.world.change(y.box, y.heavier()); }, true, false, true},
      {"a joint", [](Yard& y) { y.world.change(y.hinge, y.world.description(y.hinge)); }, true, false, true},
      {"a material", [](Yard& y) { y.world.set_material(1, {.friction = 0.4}); }, true, true, false},
      {"the floor's", [](Yard& y) { y.world.set_material(0, {.friction = 0.4}); }, false, true, false},
      {"a pair of the ball and the floor",
       [](Yard& y) { y.world.set_material_pair({.material_a = 1, .material_b = 0, .friction = 1, .restitution = 0}); },
       true, true, false},
      {"a body that becomes static", [](Yard& y) { y.world.change(y.ball, y.fixed()); }, false, false, false},
      {"a speed that nobody has", [](Yard& y) { y.world.set_speed_limit(1000); }, true, true, true},
  };
  for (const Deed& deed : deeds) {
    SCOPED_TRACE(deed.what);
    Sleepers sleepers;
    deed.act(sleepers.yard);
    sleepers.world.step();
    sleepers.expect_asleep(deed.stack, deed.box, deed.ball);
    sleepers.world.step(20);
    Sleepers twins({.device = "auto", .precision = "double"});
    deed.act(twins.yard);
    twins.world.step(21);
    EXPECT_EQ(twins.world.state_hash(), sleepers.world.state_hash());
  }
}

// What sleeps on a body that is made static touches it still; what that body touched itself it touches no more.
TEST(WorldChangesBits, ASleeperThatIsMadeStaticCarriesOn) {
  Sleepers sleepers;
  World& world = sleepers.world;
  BodyDescription fixed = world.description(sleepers.yard.low);
  fixed.kind = BODY_STATIC, fixed.mass = 0, fixed.inertia = {0, 0, 0};
  world.change(sleepers.yard.low, fixed);
  world.step();
  ASSERT_EQ(world.events().size(), 1u);
  EXPECT_EQ(world.events()[0].kind, EVENT_CONTACT_END);
  EXPECT_EQ(world.description(world.events()[0].a).kind, BODY_STATIC);
  EXPECT_EQ(world.description(world.events()[0].b).kind, BODY_STATIC);
  world.step(100);
  EXPECT_TRUE(world.is_asleep(sleepers.yard.high));
  for (const BodyContact& contact : world.contacts())
    EXPECT_TRUE(world.description(contact.a).kind == BODY_DYNAMIC || world.description(contact.b).kind == BODY_DYNAMIC);
}

// ---- events

using Kinds = std::vector<EventKind>;

Kinds kinds_of(World& world) {
  Kinds kinds;
  for (const BodyEvent& event : world.events()) kinds.push_back(event.kind);
  return kinds;
}

// Whatever parts them, a touch ends with the next step, and begins again where it is let.
TEST(WorldChangesBits, ATouchThatFiltersCutEnds) {
  for (const char* pairs : {"shapes", "bodies", "triangles"}) {
    for (const bool sleeping : {false, true}) {
      for (const bool of_floor : {false, true}) {
        SCOPED_TRACE(std::string(pairs) + (sleeping ? ", asleep" : "") + (of_floor ? ", of the floor" : ""));
        Scene scene = sleeping ? Sleepers::sleepy() : Yard::scene();
        scene.settings.event_pairs = pairs == std::string("shapes")   ? EventPairs::shapes
                                     : pairs == std::string("bodies") ? EventPairs::bodies
                                                                      : EventPairs::triangles;
        World world(scene, in_double());
        const BodyHandle floor = *world.find("floor"), box = world.add(box_at({0, 0, 0.5}));
        world.step(100);
        EXPECT_EQ(world.is_asleep(box), sleeping);
        const BodyHandle who = of_floor ? floor : box;
        BodyDescription filtered = world.description(who);
        filtered.shapes[0].mask = 0;
        world.change(who, filtered);
        world.step();
        EXPECT_EQ(kinds_of(world), Kinds{EVENT_CONTACT_END});
        EXPECT_LT(world.velocity(box).linear[2], -0.09) << "it falls";
        filtered.shapes[0].mask = 0xffffffffu;
        world.change(who, filtered);
        world.step();
        EXPECT_EQ(kinds_of(world), Kinds{EVENT_CONTACT_BEGIN});
        world.step();
        EXPECT_EQ(kinds_of(world), Kinds{});
      }
    }
  }
}

// Nothing can touch any more, so that there are no contacts to be looked for at all.
TEST(WorldChangesBits, ATouchEndsWhereNothingCanTouchAnyMore) {
  World world(Yard::scene(), in_double());
  const BodyHandle box = world.add(box_at({0, 0, 0.5}));
  world.step(20);
  BodyDescription fixed = world.description(box);
  fixed.kind = BODY_STATIC, fixed.mass = 0, fixed.inertia = {0, 0, 0};
  world.change(box, fixed);
  world.step();
  EXPECT_EQ(kinds_of(world), Kinds{EVENT_CONTACT_END});
  world.step();
  EXPECT_EQ(kinds_of(world), Kinds{});
}

// A shape that is another kind begins anew, one that has grown goes on; a body goes on for as long as a shape does.
TEST(WorldChangesBits, ShapesAreKnownByIndexAndKind) {
  for (const EventPairs pairs : {EventPairs::shapes, EventPairs::bodies}) {
    Scene scene = Yard::scene();
    scene.settings.event_pairs = pairs;
    World world(scene, in_double());
    BodyDescription twin = box_at({0, 0, 0.5});
    twin.shapes.push_back(twin.shapes[0]);
    const BodyHandle box = world.add(twin);
    world.step(20);
    twin.shapes[0].half_extents[0] = 0.7;
    world.change(box, twin);
    world.step();
    EXPECT_EQ(kinds_of(world), Kinds{});
    twin.shapes[1] = {.kind = SHAPE_SPHERE, .radius = 0.5};
    world.change(box, twin);
    world.step();
    const bool of_bodies = pairs == EventPairs::bodies;
    EXPECT_EQ(kinds_of(world), of_bodies ? Kinds{} : (Kinds{EVENT_CONTACT_END, EVENT_CONTACT_BEGIN}));
    if (!of_bodies) {
      EXPECT_EQ(world.events()[0].shape_a + world.events()[0].shape_b, 1u);
    }
    twin.shapes.pop_back();
    world.change(box, twin);
    world.step();
    EXPECT_EQ(kinds_of(world), of_bodies ? Kinds{} : Kinds{EVENT_CONTACT_END});
  }
}

// A gate that becomes a wall, and a guest that becomes static, leave each other.
TEST(WorldChangesBits, TriggersAreLeftByWhatTheyFeelNoMore) {
  for (const char* what : {"wall", "static", "filtered"}) {
    SCOPED_TRACE(what);
    Scene scene = empty_scene();
    World world(scene, in_double());
    BodyDescription gate;
    gate.kind = BODY_STATIC;
    gate.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 2, .trigger = true});
    const BodyHandle trigger = world.add(gate), guest = world.add(ball_at({0, 0, 0}));
    world.step();
    ASSERT_EQ(kinds_of(world), Kinds{EVENT_TRIGGER_ENTER});
    world.step();
    if (what == std::string("wall")) {
      gate.shapes[0] = {.kind = SHAPE_SPHERE, .radius = 0.1};
      world.change(trigger, gate);
    } else if (what == std::string("static")) {
      BodyDescription fixed = world.description(guest);
      fixed.kind = BODY_STATIC, fixed.mass = 0, fixed.inertia = {0, 0, 0};
      world.change(guest, fixed);
    } else {
      BodyDescription other = world.description(guest);
      other.shapes[0].category = 2;
      gate.shapes[0].mask = 1;
      world.change(guest, other), world.change(trigger, gate);
    }
    world.step();
    ASSERT_FALSE(world.events().empty());
    EXPECT_EQ(world.events()[0].kind, EVENT_TRIGGER_LEAVE);
    EXPECT_EQ(world.events()[0].a, trigger);
    EXPECT_EQ(world.events()[0].b, guest);
  }
}

}  // namespace
}  // namespace lockstep::world_changes_bits_test
