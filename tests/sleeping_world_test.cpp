// Sleepers in the library: what a user does wakes those it is done to.
#include <cmath>

#include "tests/command_line.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::sleeping_world_test {
namespace {

Scene sleepy_scene() {
  Scene scene = ground_scene();
  scene.settings.sleeping = SleepSettings{.after = 0.2};
  return scene;
}

// Two boxes on each other and one apart, asleep.
struct Sleepers {
  World world{sleepy_scene(), in_double()};
  BodyHandle low = world.add(box_at({0, 0, 0.5})), high = world.add(box_at({0, 0, 1.5}));
  BodyHandle separate = world.add(box_at({5, 0, 0.5}));

  Sleepers() {
    world.step(60);
    expect_asleep(true, true);
  }

  void expect_asleep(bool pile, bool other) {
    EXPECT_EQ(world.is_asleep(low), pile);
    EXPECT_EQ(world.is_asleep(high), pile);
    EXPECT_EQ(world.is_asleep(separate), other);
  }
};

TEST(SleepingWorld, WhatIsDoneToABodyWakesItsIsland) {
  const std::vector<std::function<void(World&, BodyHandle)>> deeds = {
      [](World& world, BodyHandle body) {
        world.apply_impulse(body, {0, 0, 0.01});
      },
      [](World& world, BodyHandle body) {
        world.set_velocity(body, {{0.02, 0, 0}, {0, 0, 0}});
      },
      [](World& world, BodyHandle body) {
        world.apply(body, {{1, 0, 0}, {0, 0, 0}});
      },
      [](World& world, BodyHandle body) { world.set_load(body, [](double) {
                                            return Wrench{{0, 0, -1}, {0, 0, 0}};
                                          }); },
      [](World& world, BodyHandle body) { world.wake(body); },
      [](World& world, BodyHandle body) { world.teleport(body, world.pose(body)); },
  };
  for (const auto& deed : deeds) {
    Sleepers sleepers;
    deed(sleepers.world, sleepers.high);
    sleepers.world.step();
    sleepers.expect_asleep(false, true);
    sleepers.world.step(60);
    sleepers.expect_asleep(true, true);  // and it falls asleep again, under a constant load too
  }
}

// Awake, in the step in which they fall asleep, asleep, and asleep where the world has been made anew meanwhile.
TEST(SleepingWorld, SleepersWeighWhatTheyWeigh) {
  for (const Solver solver : {Solver::small_steps, Solver::gauss_seidel}) {
    Scene scene = sleepy_scene();
    replace_solver(scene.settings, solver);
    World world(scene, in_double());
    const BodyHandle low = world.add(box_at({0, 0, 0.5})), high = world.add(box_at({0, 0, 1.5}));
    const double weight = 2 * 9.81 * 0.01;
    const auto expect_weight = [&] {
      double on_low = 0, on_floor = 0;
      for (const BodyContact& contact : world.contacts()) {
        const Vector3 up = contact.a == low || contact.a == high ? contact.impulse : exact::scale(-1, contact.impulse);
        (contact.a == high || contact.b == high ? on_low : on_floor) += up[2];
        EXPECT_NEAR(std::abs(contact.normal[2]), 1, 1e-6);
        EXPECT_NEAR(contact.point[2], contact.a == high || contact.b == high ? 1 : 0, 2e-3);
      }
      EXPECT_NEAR(std::abs(on_low), weight, 1e-3 * weight);
      EXPECT_NEAR(on_floor, 2 * weight, 2e-3 * weight);
      EXPECT_EQ(world.contacts().size(), 8u);
    };
    world.step(15);
    bool slept = false;
    for (u32 step = 0; step < 60; ++step) {
      world.step();
      slept = slept || world.is_asleep(high);
      expect_weight();
    }
    EXPECT_TRUE(slept);
    world.add(box_at({9, 0, 5}));
    world.step();
    EXPECT_TRUE(world.is_asleep(high));
    expect_weight();
  }
}

TEST(SleepingWorld, WhereSupportGoesAwayWhatItBoreWakesAndFalls) {
  Sleepers sleepers;
  sleepers.world.remove(sleepers.low);
  sleepers.world.step();
  EXPECT_FALSE(sleepers.world.is_asleep(sleepers.high));
  EXPECT_TRUE(sleepers.world.is_asleep(sleepers.separate));
  EXPECT_LT(sleepers.world.velocity(sleepers.high).linear[2], -0.05);
  sleepers.world.step(100);
  EXPECT_NEAR(sleepers.world.pose(sleepers.high).position[2], 0.5, 0.002);
  EXPECT_TRUE(sleepers.world.is_asleep(sleepers.high));
}

TEST(SleepingWorld, WhereTheFloorGoesAllWake) {
  Sleepers sleepers;
  sleepers.world.remove(*sleepers.world.find("floor"));
  sleepers.world.step();
  sleepers.expect_asleep(false, false);
  EXPECT_LT(sleepers.world.velocity(sleepers.separate).linear[2], -0.05);
}

// Where a wall comes is not looked for on behalf of sleepers: they look themselves, and those it overlaps are pushed.
TEST(SleepingWorld, AllWakeWhereAStaticBodyArrives) {
  Sleepers sleepers;
  BodyDescription wall = box_at({5.8, 0, 0.5});
  wall.kind = BODY_STATIC;
  sleepers.world.add(wall);
  sleepers.world.step();
  sleepers.expect_asleep(false, false);
  sleepers.world.step(120);
  EXPECT_LT(sleepers.world.pose(sleepers.separate).position[0], 4.9);
  sleepers.expect_asleep(true, true);
}

TEST(SleepingWorld, WhatComesAwayFromSleepersLeavesThemAlone) {
  Sleepers sleepers;
  sleepers.world.add(box_at({20, 0, 0.5}));
  sleepers.world.step();
  sleepers.expect_asleep(true, true);
  // islands still are those that they were
  sleepers.world.wake(sleepers.separate);
  sleepers.world.step();
  sleepers.expect_asleep(true, false);
}

TEST(SleepingWorld, AMotorThatIsSetOtherwiseWakesWhatItDrives) {
  World world(sleepy_scene(), in_double());
  BodyDescription wheel = ball_at({0, 0, 3});
  const BodyHandle body = world.add(wheel);
  JointDescription hinge;
  hinge.kind = JOINT_HINGE;
  hinge.anchor_a = hinge.anchor_b = {0, 0, 3};
  hinge.axis = {0, 1, 0};
  hinge.motor_speed = 0;
  hinge.motor_force = 1e6;
  const JointHandle joint = world.add(hinge, body);
  world.step(40);
  ASSERT_TRUE(world.is_asleep(body));
  world.set_motor(joint, 1, 1e6);
  world.step();
  EXPECT_FALSE(world.is_asleep(body));
  EXPECT_NEAR(std::abs(world.velocity(body).angular[1]), 1, 0.01);
  world.set_motor(joint, 0, 1e6);
  world.step(40);
  ASSERT_TRUE(world.is_asleep(body));
  world.remove(joint);
  world.step();
  EXPECT_FALSE(world.is_asleep(body));
}

TEST(SleepingWorld, NobodySleepsUnasked) {
  World world(ground_scene(), in_double());
  const BodyHandle body = world.add(box_at({0, 0, 0.5}));
  world.step(200);
  EXPECT_FALSE(world.is_asleep(body));
}

using SleepingWorldRecorded = CommandLine;

TEST_F(SleepingWorldRecorded, WhatAUserWakesIsReplayed) {
  const std::string path = file("sleepers.h5").string();
  {
    Scene scene = sleepy_scene();
    scene.settings.loads = true;
    World world(scene, in_double());
    const BodyHandle body = world.add(box_at({0, 0, 0.5})), other = world.add(box_at({5, 0, 0.5}));
    world.record(path);
    world.step(40);
    ASSERT_TRUE(world.is_asleep(body));
    world.apply_impulse(body, {0.5, 0, 0});
    world.step(5);
    world.apply(other, {{0, 0, 5}, {0, 0, 0}});
    world.step(40);
    ASSERT_TRUE(world.is_asleep(other));
    world.end_recording();
  }
  for (const char* device : {"reference", "auto"}) {
    const Outcome outcome = run("verify " + path + " --device " + device);
    EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
  }
}

// Waking by other hands than the simulation's own is replayed: the state stays what the twins make of it.
TEST(SleepingWorld, WhatWakesIsTheSameOnTheDevice) {
  std::uint64_t hashes[2];
  for (const char* device : {"reference", "auto"}) {
    World world(sleepy_scene(), {.device = device, .precision = "float"});
    const BodyHandle low = world.add(box_at({0, 0, 0.5})), high = world.add(box_at({0, 0, 1.5}));
    world.add(box_at({5, 0, 0.5}));
    world.step(60);
    world.apply_impulse(high, {0.3, 0, 0});
    world.step(3);
    world.remove(low);
    world.step(40);
    hashes[std::string(device) == "auto"] = world.state_hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace lockstep::sleeping_world_test
