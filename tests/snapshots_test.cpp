// Worlds that go back to what they were: the same steps, the same bits.
#include <deque>

#include "host/scene/read.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::snapshots_test {
namespace {

using Hashes = std::vector<std::uint64_t>;

Hashes hashes_of(World& world, u32 steps) {
  Hashes hashes;
  for (u32 i = 0; i < steps; ++i) {
    world.step();
    hashes.push_back(world.state_hash());
  }
  return hashes;
}

/// Back to the snapshot, and the steps after it once more.
void expect_again(World& world, const Snapshot& snapshot, const Hashes& hashes) {
  world.restore(snapshot);
  EXPECT_EQ(hashes_of(world, static_cast<u32>(hashes.size())), hashes);
}

template <class Test>
void everywhere(const Test& test) {
  for (const char* device : {"reference", "auto"}) {
    for (const char* precision : {"float", "double"}) {
      SCOPED_TRACE(std::string(device) + ", " + precision);
      test(WorldOptions{.device = device, .precision = precision});
    }
  }
}

// Boxes and balls that fall on each other, pushed aside by a load and by a platform that moves.
World pile(const WorldOptions& options) {
  Scene scene = ground_scene();
  scene.settings.events = true;
  World world(scene, options);
  for (int i = 0; i < 6; ++i) {
    BodyDescription body = i % 2 ? box_at({0.1 * i, 0, 0.6 + 1.05 * i}) : ball_at({0.1 * i, 0.05, 0.6 + 1.05 * i});
    body.name = "body " + std::to_string(i);
    world.add(body);
  }
  return world;
}

JointDescription hinge_at(const Vector3& anchor, const std::string& name) {
  return {.name = name, .kind = JOINT_HINGE, .anchor_a = anchor, .anchor_b = anchor, .axis = {0, 1, 0}};
}

TEST(Snapshots, EightThatAreKeptOverTwentyStepsGiveEqualHashesEach) {
  everywhere([](const WorldOptions& options) {
    World world = pile(options), unsaved = pile(options);
    std::deque<Snapshot> ring;
    Hashes hashes;
    world.step(60);
    unsaved.step(60);
    for (u32 step = 0; step < 20; ++step) {
      ring.push_back(world.save());
      if (ring.size() > 8) ring.pop_front();
      world.step();
      hashes.push_back(world.state_hash());
    }
    EXPECT_EQ(hashes_of(unsaved, 20), hashes) << "saving changes nothing";
    ASSERT_EQ(ring.size(), 8u);
    for (const u32 k : {7u, 0u, 3u, 5u, 1u, 6u, 2u, 4u}) {
      world.restore(ring[k]);
      EXPECT_EQ(world.steps_done(), 72 + k);
      EXPECT_EQ(world.time(), (72 + k) * 0.01);
      EXPECT_EQ(ring[k].steps_done(), 72 + k);
      EXPECT_EQ(ring[k].time(), world.time());
      EXPECT_EQ(world.state_hash(), hashes[11 + k]);
      EXPECT_EQ(hashes_of(world, 8 - k), Hashes(hashes.end() - (8 - k), hashes.end()));
    }
    world.restore(ring[1]);
    world.restore(ring[6]);  // forth
    EXPECT_EQ(hashes_of(world, 2), Hashes(hashes.end() - 2, hashes.end()));
  });
}

TEST(Snapshots, BodiesAndJointsThatCameOrWentAreAsTheyWere) {
  everywhere([](const WorldOptions& options) {
    World world = pile(options);
    const BodyHandle second = *world.find("body 1"), third = *world.find("body 2"), last = *world.find("body 5");
    const JointHandle hinge = world.add(hinge_at({0.5, 0, 6}, "hinge"), third, last);
    world.step(40);
    const Snapshot snapshot = world.save();
    const std::vector<BodyHandle> bodies(world.bodies().begin(), world.bodies().end());
    const Hashes hashes = hashes_of(world, 30);
    const Pose pose = world.pose(last);

    world.remove(second);
    const BodyHandle added = world.add(ball_at({0, 0, 9}));
    world.step(5);
    world.remove(third);  // and the hinge with it
    const JointHandle nail = world.add(hinge_at({0, 0, 9}, "nail"), added);
    world.teleport(last, {.position = {3, 0, 4}});
    world.step(5);
    const Snapshot other = world.save();
    const Hashes of_other = hashes_of(world, 10);

    world.restore(snapshot);
    EXPECT_EQ(std::vector<BodyHandle>(world.bodies().begin(), world.bodies().end()), bodies);
    EXPECT_TRUE(world.contains(second) && world.contains(third) && world.contains(hinge));
    EXPECT_EQ(world.find("body 1"), second);
    EXPECT_EQ(world.description(hinge).name, "hinge");
    EXPECT_FALSE(world.contains(added) || world.contains(nail) || world.find_joint("nail"));
    EXPECT_EQ(refusal([&] { world.pose(added); }), "body with the handle 7: is not in this world any more");
    EXPECT_EQ(hashes_of(world, 30), hashes);
    EXPECT_EQ(world.pose(last).position, pose.position);

    world.restore(other);
    EXPECT_TRUE(world.contains(added) && world.contains(nail));
    EXPECT_FALSE(world.contains(second) || world.contains(third) || world.contains(hinge));
    EXPECT_EQ(hashes_of(world, 10), of_other);

    world.restore(snapshot);
    const BodyHandle new_one = world.add(ball_at({0, 0, 9}));
    EXPECT_NE(new_one, added) << "a handle is never given twice";
    EXPECT_FALSE(world.contains(added));
    world.step();
    EXPECT_NEAR(world.pose(new_one).position[2], 9, 0.01);
  });
}

TEST(Snapshots, ContactsAndEventsAreThoseOfThen) {
  everywhere([](const WorldOptions& options) {
    World world = pile(options);
    u32 steps = 0;
    do world.step();
    while (++steps < 200 && world.events().empty());
    World twin = pile(options);  // which nobody asks for events
    twin.step(steps);
    const Snapshot untold = twin.save();
    const Snapshot told = world.save();
    const std::vector<BodyEvent> events(world.events().begin(), world.events().end());
    const std::vector<BodyContact> contacts(world.contacts().begin(), world.contacts().end());
    ASSERT_FALSE(contacts.empty());
    const BodyHandle touching = contacts[0].b;
    world.remove(touching);
    const Snapshot pending = world.save();  // its touches end with the next step
    world.step();
    const std::vector<BodyEvent> ends(world.events().begin(), world.events().end());
    ASSERT_FALSE(ends.empty());
    world.step(30);

    const auto expect_events = [&](const std::vector<BodyEvent>& wanted) {
      ASSERT_EQ(world.events().size(), wanted.size());
      for (std::size_t i = 0; i < wanted.size(); ++i) {
        EXPECT_EQ(world.events()[i].kind, wanted[i].kind);
        EXPECT_EQ(world.events()[i].a, wanted[i].a);
        EXPECT_EQ(world.events()[i].b, wanted[i].b);
      }
    };
    world.restore(told);
    expect_events(events);
    ASSERT_EQ(world.contacts().size(), contacts.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      EXPECT_EQ(world.contacts()[i].a, contacts[i].a);
      EXPECT_EQ(world.contacts()[i].point, contacts[i].point);
      EXPECT_EQ(world.contacts()[i].impulse, contacts[i].impulse);
    }
    EXPECT_EQ(world.errors().contacts, 0u) << "what the last step solved is not kept";
    world.restore(pending);
    world.step();
    expect_events(ends);
    twin.step(20);
    twin.restore(untold);
    EXPECT_EQ(twin.events().size(), events.size());
    EXPECT_EQ(twin.contacts().size(), contacts.size());
  });
}

TEST(Snapshots, SleepersSleepOnAndWakeAgain) {
  everywhere([](const WorldOptions& options) {
    Scene scene = ground_scene();
    scene.settings.sleeping = SleepSettings{.after = 0.1};
    World world(scene, options);
    const BodyHandle low = world.add(box_at({0, 0, 0.5})), high = world.add(box_at({0.1, 0, 1.5}));
    world.step(50);
    ASSERT_TRUE(world.is_asleep(low) && world.is_asleep(high));
    world.step(3);  // at rest: steps only count
    const Snapshot asleep = world.save();
    const Hashes at_rest = hashes_of(world, 5);
    world.apply_impulse(high, {0, 0, 4});
    const Snapshot woken = world.save();  // the impulse is in it
    const Hashes after_blow = hashes_of(world, 40);
    EXPECT_FALSE(world.is_asleep(high));
    world.restore(asleep);
    EXPECT_TRUE(world.is_asleep(high));
    EXPECT_EQ(hashes_of(world, 5), at_rest);
    expect_again(world, woken, after_blow);
  });
}

TEST(Snapshots, ForcesLoadsTargetsAndMotorsAreThoseOfThen) {
  everywhere([](const WorldOptions& options) {
    World world = pile(options);
    BodyDescription lift = box_at({4, 0, 0.5});
    lift.kind = BODY_KINEMATIC, lift.mass = 0, lift.inertia = {0, 0, 0};
    const BodyHandle platform = world.add(lift), crate = world.add(box_at({4, 0, 1.5})),
                     wheel = world.add(ball_at({8, 0, 3}));
    JointDescription axle = hinge_at({8, 0, 3}, "axle");
    axle.motor_speed = 1, axle.motor_force = 100;
    const JointHandle joint = world.add(axle, wheel);
    world.set_load(crate, [](double time) { return Wrench{{20 * time, 0, 0}, {0, 0, 0}}; });
    world.step(10);
    world.set_motor(joint, -3, 500);
    world.set_kinematic_target(platform, {.position = {4, 0, 0.52}});
    world.apply_force(wheel, {0, 0, 900}, {8, 0.2, 3});
    world.set_velocity(crate, {{0, 0.5, 0}, {0, 0, 0}});
    const Snapshot snapshot = world.save();  // all of it is to be done yet
    const Hashes hashes = hashes_of(world, 20);
    EXPECT_EQ(world.description(joint).motor_speed, -3);
    world.set_motor(joint, 7, 800);
    world.set_load(crate, {});
    world.set_load(wheel, [](double) { return Wrench{{0, 5, 0}, {0, 0, 0}}; });
    world.set_kinematic_target(platform, {.position = {4, 0, 0.9}});
    world.step(3);
    const Snapshot later = world.save();
    const Hashes of_later = hashes_of(world, 4);
    world.restore(snapshot);
    EXPECT_EQ(world.description(joint).motor_speed, -3);
    EXPECT_EQ(world.description(joint).motor_force, 500);
    EXPECT_EQ(hashes_of(world, 20), hashes);
    world.restore(later);
    EXPECT_EQ(world.description(joint).motor_speed, 7);
    EXPECT_EQ(hashes_of(world, 4), of_later);
  });
}

// Warm starts of joints and contacts, articulations and their loops, springs of particles, height fields, triggers,
// what is looked for within the step, laws of impact, sleepers: of each scene two steps that follow each other twice.
TEST(Snapshots, EveryKindOfSceneGoesBack) {
  for (const char* name :
       {"rag_doll", "rover", "strider", "squeezer", "rope_bridge", "particles_roll", "sensor_gate", "dominoes",
        "cylinders_and_hulls", "mixed_spheres", "superball", "rolling_resistance", "skates", "terrain", "screw_nut",
        "free_flight", "incline_relaxed", "three_cubes", "governor"}) {
    for (const char* device : {"reference", "auto"}) {
      SCOPED_TRACE(std::string(name) + ", " + device);
      World world = World::load(name, {.device = device});
      world.step(12);
      const Snapshot snapshot = world.save();
      const Hashes hashes = hashes_of(world, 6);
      world.step(9);
      expect_again(world, snapshot, hashes);
    }
  }
}

TEST(Snapshots, JointsSolvedDirectlyAndOtherSolversGoBack) {
  for (const char* device : {"reference", "auto"}) {
    for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps, Solver::jacobi, Solver::accelerated_gradient,
                                Solver::cell_gauss_seidel}) {
      for (const JointSolver joints : {JointSolver::sweeps, JointSolver::direct}) {
        Scene scene = read_scene("rag_doll");
        replace_solver(scene.settings, solver);
        const bool takes_direct = solver == Solver::gauss_seidel || solver == Solver::cell_gauss_seidel;
        if (joints == JointSolver::direct && !takes_direct) continue;  // refused
        scene.settings.joint_solver = joints;
        SCOPED_TRACE(std::string(device) + ", " + name_of(solver) + ", " + name_of(joints));
        World world(scene, {.device = device});
        world.step(10);
        const Snapshot snapshot = world.save();
        const Hashes hashes = hashes_of(world, 5);
        expect_again(world, snapshot, hashes);
      }
    }
  }
}

TEST(Snapshots, OraclesGoBackTooAndSoDoesWhatTheyLeftUnsolved) {
  for (const char* solver : {"nsgs", "mixed_ldlt", "reduced_nsgs", "impulse_based"}) {
    SCOPED_TRACE(solver);
    World world = World::load("rag_doll", {.solver = solver});
    world.step(20);
    const Snapshot snapshot = world.save();
    const u32 unsolved = world.unsolved().count;
    const Hashes hashes = hashes_of(world, 10);
    world.step(20);
    world.restore(snapshot);
    EXPECT_EQ(world.unsolved().count, unsolved);
    EXPECT_EQ(hashes_of(world, 10), hashes);
  }
  Scene scene = ground_scene();
  replace_solver(scene.settings, Solver::nsgs);
  scene.settings.iterations = 1;
  scene.settings.tolerance = 1e-14;
  World world(scene, {});
  for (int i = 0; i < 4; ++i) world.add(box_at({0, 0, 0.5 + i}));
  world.step(5);
  const Snapshot snapshot = world.save();
  const u32 unsolved = world.unsolved().count;
  world.step(5);
  ASSERT_GT(world.unsolved().count, unsolved);
  world.restore(snapshot);
  EXPECT_EQ(world.unsolved().count, unsolved);
}

TEST(Snapshots, ListsMayHaveBecomeLongerSince) {
  everywhere([](const WorldOptions& options) {
    World world(ground_scene(), options);
    for (int i = 0; i < 64; ++i) world.add(box_at({1.01 * (i % 8), 1.01 * (i / 8), 2}));
    world.step();
    const Snapshot separated = world.save();
    const Hashes hashes = hashes_of(world, 80);  // four contacts each, and their neighbours'
    ASSERT_GT(world.contacts().size(), 200u);
    const Snapshot together = world.save();
    const Hashes after = hashes_of(world, 5);
    expect_again(world, separated, hashes);
    expect_again(world, together, after);
  });
}

TEST(Snapshots, AStepThatFailedIsForgotten) {
  everywhere([](const WorldOptions& options) {
    World world = pile(options);
    const BodyHandle body = *world.find("body 0");
    world.step(5);
    const Snapshot snapshot = world.save();
    const Hashes hashes = hashes_of(world, 5);
    world.restore(snapshot);
    world.set_velocity(body, {{2e5, 0, 0}, {0, 0, 0}});
    EXPECT_THROW(world.step(), Error);
    EXPECT_THROW(world.step(), Error) << "none follows it";
    EXPECT_THROW(world.save(), Error);
    EXPECT_EQ(world.unsolved().count, 1u);
    world.restore(snapshot);
    EXPECT_EQ(world.unsolved().count, 0u);
    EXPECT_EQ(hashes_of(world, 5), hashes);
  });
}

TEST(Snapshots, TheVerdictIsThatOfThen) {
  World world = pile(in_double());
  world.step(30);
  const Snapshot snapshot = world.save();
  const double speed = world.verdict()[Criterion::speed].worst;
  world.set_velocity(*world.find("body 3"), {{90000, 0, 0}, {0, 0, 0}});
  world.step();
  EXPECT_GT(world.verdict()[Criterion::speed].worst, 1000 + speed);
  world.restore(snapshot);
  EXPECT_EQ(world.verdict()[Criterion::speed].worst, speed);
}

TEST(Snapshots, OfAnotherWorldOrOfNothingAreRefused) {
  World world = pile(in_double()), other = pile(in_double());
  const Snapshot snapshot = other.save();
  EXPECT_EQ(refusal([&] { world.restore(snapshot); }),
            "snapshot: is of another world; only the one that made it goes back to it");
  EXPECT_EQ(refusal([&] { world.restore({}); }), "snapshot: is of nothing; save() makes one");
  EXPECT_FALSE(Snapshot());
  EXPECT_EQ(Snapshot().steps_done(), 0u);
  World moved = std::move(other);
  moved.step(3);
  moved.restore(snapshot);  // the same one by another name
  EXPECT_EQ(moved.steps_done(), 0u);
}

TEST(Snapshots, OutliveChangesAndTheirWorld) {
  for (const char* device : {"reference", "auto"}) {
    Snapshot snapshot, empty;
    {
      World world(empty_scene(), {.device = device});
      empty = world.save();
      const BodyHandle ball = world.add(ball_at({0, 0, 0}));
      world.set_velocity(ball, {{1, 0, 0}, {0, 0, 0}});
      world.step(10);
      snapshot = world.save();
      world.remove(ball);
      const Snapshot without = world.save();
      world.restore(empty);
      EXPECT_TRUE(world.bodies().empty());
      EXPECT_EQ(world.steps_done(), 0u);
      world.restore(without);
      EXPECT_TRUE(world.bodies().empty());
      EXPECT_EQ(world.steps_done(), 10u);
      world.restore(snapshot);
      EXPECT_NEAR(world.pose(ball).position[0], 0.1, 1e-6);
    }
    EXPECT_TRUE(snapshot);
    EXPECT_EQ(snapshot.steps_done(), 10u);
  }
}

TEST(Snapshots, QuestionsAreAnsweredOfTheStateThatIsThere) {
  for (const char* device : {"reference", "auto"}) {
    World world(ground_scene(), {.device = device});
    const BodyHandle ball = world.add(ball_at({0, 0, 5}));
    world.step();
    const Snapshot snapshot = world.save();
    const auto height = [&] { return 10 - world.cast_ray({0, 0, 10}, {0, 0, -1})->distance - 0.5; };
    const double before = height();
    EXPECT_NEAR(before, 5, 0.01);
    world.step(50);
    EXPECT_LT(height(), 4.5);
    world.restore(snapshot);
    EXPECT_EQ(height(), before);
    EXPECT_NEAR(world.pose(ball).position[2], before, 1e-6);
  }
}

}  // namespace
}  // namespace lockstep::snapshots_test
