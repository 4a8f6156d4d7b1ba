// The library's world: what acts on bodies against closed forms, bodies that come and go, and that all of it has the
// same bits everywhere.
#include "include/lockstep/world.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/backends/canary.hpp"
#include "host/backends/device_backend.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/report/report.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/world/angular_velocity.hpp"
#include "tests/library_worlds.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::world_test {
namespace {

constexpr double pi = 3.14159265358979;

// ---- a world is a simulation

TEST(World, HasTheBitsOfASimulation) {
  const Scene scene = read_scene("box_stack");
  const InitialState<float> state = compile<float>(scene);
  Simulation<float> simulation(std::make_unique<ReferenceBackend<float>>(state), state.params);
  for (int i = 0; i < 30; ++i) simulation.step();
  World world(scene, {.device = "reference"});
  world.step(30);
  EXPECT_EQ(world.state_hash(), combined_state_hash(simulation.world_hashes()));
  EXPECT_EQ(world.steps_done(), 30u);
  EXPECT_NEAR(world.time(), 30 * scene.settings.dt, 1e-12);
}

// By the canary of the device that computes: for a few bodies the thread that calls, where the driver can do so.
TEST(World, SaysWhatItComputesOn) {
  const WorldDevice reference = World::load("box_stack", {.device = "reference"}).device();
  EXPECT_EQ(reference.name, "reference");
  EXPECT_TRUE(reference.bit_exact);

  const DeviceInfo info = test_device();
  const InitialState<float> state = compile<float>(read_scene("box_stack"));
  const DeviceBackend<float> backend(state, info);
  const CanaryVerdict verdict = run_canary(info, false, backend.lanes(), backend.threads());
  const WorldDevice device = World::load("box_stack", {.device = std::to_string(info.index)}).device();
  EXPECT_EQ(device.name, backend.name());
  EXPECT_EQ(device.bit_exact, verdict.bit_exact());
  EXPECT_EQ(device.canary, describe(verdict));
}

TEST(World, FindsBodiesByName) {
  World world = World::load("slide_to_roll", {.device = "reference"});
  EXPECT_FALSE(world.find("nobody"));
  for (const BodyHandle body : world.bodies()) {
    const std::string& name = world.description(body).name;
    if (!name.empty()) {
      EXPECT_EQ(*world.find(name), body);
    }
  }
}

// ---- what acts

TEST(World, ALoadThatCarriesTheWeightKeepsABodyInTheAir) {
  for (const u32 substeps : {1u, 5u}) {
    Scene scene = ground_scene();
    scene.settings.substeps = substeps;
    World world(scene, in_double());
    const BodyHandle box = world.add(box_at({0, 0, 3}, 2));
    world.set_load(box, [](double) -> Wrench { return {.force = {0, 0, 2 * 9.81}}; });
    world.step(100);
    EXPECT_NEAR(world.pose(box).position[2], 3, 1e-12);
    world.set_load(box, nullptr);  // and without it falls
    world.step(10);
    EXPECT_NEAR(world.velocity(box).linear[2], -9.81 * 0.1, 1e-12);
  }
}

// A force that grows evenly, F = k t: v = k t^2 / 2 m, which the middle of the step gives exactly.
TEST(World, ALoadIsAFunctionOfTime) {
  World world(empty_scene(), in_double());
  const BodyHandle table = world.add(box_at({0, 0, 0}, 4)), function = world.add(box_at({5, 0, 0}, 4));
  world.set_load(table, load_table({{0, {}}, {1, {.force = {8, 0, 0}}}}));
  world.set_load(function, [](double time) -> Wrench { return {.force = {8 * time, 0, 0}}; });
  world.step(100);
  EXPECT_NEAR(world.velocity(table).linear[0], 1, 1e-12);
  EXPECT_NEAR(world.velocity(function).linear[0], 1, 1e-12);
  world.step(50);  // the table ends with its last value
  EXPECT_NEAR(world.velocity(table).linear[0], 1 + 8 * 0.5 / 4, 1e-12);
}

TEST(World, AForceActsForAStepAndAddsUp) {
  World world(empty_scene(), in_double());
  const BodyHandle box = world.add(box_at({1, 2, 3}, 2));
  world.apply_force(box, {4, 0, 0}, {1, 2, 3});
  world.apply_force(box, {0, 6, 0}, {1, 2, 3});
  world.apply(box, {.torque = {0, 0, 1}});
  world.step(3);
  EXPECT_NEAR(world.velocity(box).linear[0], 0.01 * 4 / 2, 1e-15);
  EXPECT_NEAR(world.velocity(box).linear[1], 0.01 * 6 / 2, 1e-15);
  EXPECT_NEAR(world.velocity(box).angular[2], 0.01 * 1 / (2.0 / 6), 1e-15);  // a cube: m a^2 / 6
}

TEST(World, AForceOffTheCentreExertsATorque) {
  World world(empty_scene(), in_double());
  const BodyHandle box = world.add(box_at({0, 0, 0}, 6));  // I = 1
  world.apply_force(box, {0, 0, 10}, {0.5, 0, 0});         // moment (0, -5, 0)
  world.step();
  EXPECT_NEAR(world.velocity(box).angular[1], -0.05, 1e-15);
}

// Friction holds what is pushed with less than mu m g: a force that lasts for the whole step, not a kick at its start.
TEST(World, AForceBelowFrictionMovesNothing) {
  for (const auto& [push, slides] : {std::pair(0.95, false), std::pair(1.05, true)}) {
    World world(ground_scene(0.5), in_double());
    const BodyHandle box = world.add(box_at({0, 0, 0.5}, 2));
    const double force = push * 0.5 * 2 * 9.81;
    world.set_load(box, [force](double) -> Wrench { return {.force = {force, 0, 0}}; });
    world.step(200);
    const double v = world.velocity(box).linear[0];
    EXPECT_NEAR(v, slides ? 0.05 * 0.5 * 9.81 * 2 : 0, slides ? 0.02 : 1e-6);
  }
}

TEST(World, AnImpulseActsAtOnce) {
  World world(empty_scene(), in_double());
  BodyDescription plank;
  plank.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {1, 0.5, 0.25}});
  plank.orientation = {0, 0, std::sqrt(0.5), std::sqrt(0.5)};  // its x along y of the world
  make_solid_of_mass(plank, 12);
  const BodyHandle body = world.add(plank);
  world.apply_impulse(body, {0, 0, 6}, {0, 1, 0});  // at its end: moment (6, 0, 0), about its own y
  const Twist after = world.velocity(body);
  EXPECT_NEAR(after.linear[2], 0.5, 1e-15);
  EXPECT_NEAR(after.angular[0], 6 / (12.0 / 12 * (2 * 2 + 0.5 * 0.5)), 1e-14);
  EXPECT_NEAR(after.angular[1], 0, 1e-15);
  world.apply_impulse(body, {0, 0, -6});
  EXPECT_NEAR(world.velocity(body).linear[2], 0, 1e-15);
}

// A rod on a pivot at its end turns with impulse times arm over the inertia about the pivot.
TEST(World, AnImpulseRotatesABodyAboutItsPivot) {
  World world(parse_scene(R"({"gravity": [0, 0, 0], "settings": {"precision": "double"}, "bodies": [
      {"name": "rod", "mass": 2, "inertia": [0.5, 0.5, 0.1], "com_offset": [0, 0, -1], "pivot": [0, 0, 5]}]})",
                          "rod"),
              {.device = "reference"});
  const BodyHandle rod = *world.find("rod");
  world.apply_impulse(rod, {5, 0, 0}, {0, 0, 4});  // moment (0, -5, 0); I = 0.5 + 2
  EXPECT_NEAR(world.velocity(rod).angular[1], -2, 1e-14);
  EXPECT_NEAR(world.velocity(rod).linear[0], 2, 1e-14);
}

TEST(World, AKinematicBodyIsWhereItIsToldToBe) {
  for (const u32 substeps : {1u, 3u, 8u}) {
    Scene scene = empty_scene();
    scene.settings.substeps = substeps;
    World world(scene, in_double());
    BodyDescription door = box_at({0, 0, 0});
    door.kind = BODY_KINEMATIC;
    door.mass = 0, door.inertia = {0, 0, 0};
    const BodyHandle body = world.add(door);
    world.add(ball_at({50, 0, 0}));
    for (const double angle : {0.1, 1.0, 2.5, 2.4, -1.0}) {
      const Quaternion rotation = exact::rotation({1, 2, -2}, std::sin(angle / 2), std::cos(angle / 2));
      world.set_kinematic_target(body, {{angle, 2, 3 * angle}, rotation});
      world.step();
      const Pose pose = world.pose(body);
      for (unsigned k = 0; k < 3; ++k) EXPECT_NEAR(pose.position[k], Vector3({angle, 2, 3 * angle})[k], 1e-13);
      double same = 0;
      for (unsigned k = 0; k < 4; ++k) same += pose.orientation[k] * rotation[k];
      EXPECT_NEAR(std::abs(same), 1, 1e-13) << angle << " " << substeps;
    }
    const Pose there = world.pose(body);
    world.step(5);  // and there it stays
    EXPECT_EQ(world.pose(body).position, there.position);
    EXPECT_EQ(world.velocity(body).linear, (Vector3{0, 0, 0}));
  }
}

// A solid ball set down on a belt slides until it rolls, at 2/7 of the belt's velocity.
TEST(World, AKinematicPlaneIsABelt) {
  for (const Solver solver : {Solver::small_steps, Solver::gauss_seidel}) {
    Scene scene = ground_scene();
    replace_solver(scene.settings, solver);
    scene.bodies[0].kind = BODY_KINEMATIC;
    scene.bodies[0].velocity = {1, 0, 0};
    World world(scene, in_double());
    const BodyHandle ball = world.add(ball_at({0, 0, 0.5}));
    world.step(200);
    EXPECT_NEAR(world.velocity(ball).linear[0], 2 / 7., 1e-6);
    EXPECT_NEAR(world.velocity(ball).angular[1], -(5 / 7.) / 0.5, 1e-5);
    EXPECT_NEAR(world.pose(*world.find("floor")).position[0], 2, 1e-12);
  }
}

TEST(World, AngularVelocityBetweenIsTheInverseOfARotation) {
  for (const double angle : {1e-9, 1e-3, 0.7, pi / 2, 3.1}) {
    const Quaternion to = exact::rotation({3, -1, 2}, std::sin(angle / 2), std::cos(angle / 2));
    const Vector3 w = angular_velocity_between({0, 0, 0, 1}, to, 0.01);
    const Vector3 expected = exact::scale(angle / 0.01 / std::sqrt(14.0), {3, -1, 2});
    EXPECT_NEAR(exact::length(exact::subtract(w, expected)), 0, 1e-13 * exact::length(expected)) << angle;
  }
}

// ---- bodies that come and go

TEST(World, WhatIsFarAwayDisturbsNobody) {
  World lonely = World::load("box_stack", {.device = "reference"}),
        shared = World::load("box_stack", {.device = "reference"});
  lonely.step(20);
  shared.step(20);
  const BodyHandle guest = shared.add(ball_at({500, 0, 20}));
  lonely.step(20);
  shared.step(20);
  const auto expect_same_poses = [&] {
    const std::span<const Pose> a = lonely.poses(), b = shared.poses();
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].position, b[i].position) << i;
      EXPECT_EQ(a[i].orientation, b[i].orientation) << i;
    }
  };
  expect_same_poses();
  shared.remove(guest);
  expect_same_poses();
  EXPECT_EQ(lonely.state_hash(), shared.state_hash());
  lonely.step(20);
  shared.step(20);
  EXPECT_EQ(lonely.state_hash(), shared.state_hash());
}

TEST(World, WhatLayOnARemovedBodyFalls) {
  World world(ground_scene(), in_double());
  const BodyHandle below = world.add(box_at({0, 0, 0.5})), above = world.add(box_at({0, 0, 1.5}));
  world.step(100);
  EXPECT_NEAR(world.pose(above).position[2], 1.5, 1e-3);
  world.remove(below);
  EXPECT_FALSE(world.contains(below));
  EXPECT_EQ(world.bodies().size(), 2u);
  world.step(10);
  EXPECT_NEAR(world.velocity(above).linear[2], -9.81 * 0.1, 1e-3);
  world.step(200);
  EXPECT_NEAR(world.pose(above).position[2], 0.5, 1e-3);
  EXPECT_EQ(refusal([&] { world.pose(below); }), "body with the handle 1: is not in this world any more");
  EXPECT_NE(world.add(box_at({0, 0, 5})), below);  // a handle is never given twice
}

TEST(World, JointsGoWithTheirBodies) {
  World world = World::load("rag_doll", {.device = "reference"});
  world.step(10);
  const std::vector<BodyHandle> all(world.bodies().begin(), world.bodies().end());
  world.remove(all[all.size() / 2]);
  world.step(50);
  EXPECT_EQ(world.bodies().size(), all.size() - 1);
  for (const BodyHandle body : all)
    if (world.contains(body) && body != all.back()) world.remove(body);
  world.step(10);
  EXPECT_EQ(world.bodies().size(), 1u);
}

// The simulation is made anew twice, and nobody notices: joints keep their impulses.
TEST(World, JointsThatStayKeepTheirImpulses) {
  const std::string one =
      R"({"settings": {"solver": "gauss_seidel", "iterations": 30, "precision": "double"}, "bodies": [
      {"generator": "line", "count": 6, "step": [1, 0, 0], "bodies": [{"name": "link", "mass": 1, "shapes": [{"type": "sphere", "radius": 0.1, "collides_with": []}]}],
       "joints": [{"type": "ball", "bodies": ["link", "link+1"], "anchor": [0.5, 0, 0]}]}]})";
  World whole(parse_scene(one, "chain"), {.device = "reference"}),
      cut(parse_scene(one, "chain"), {.device = "reference"});
  whole.step(20);
  cut.step(20);
  EXPECT_EQ(whole.state_hash(), cut.state_hash());
  const BodyHandle guest = cut.add(ball_at({0, 0, 900}));
  cut.poses();
  cut.remove(guest);
  whole.step(20);
  cut.step(20);
  EXPECT_EQ(whole.state_hash(), cut.state_hash());
}

// Bodies that push each other by particles: what comes and goes far away leaves every bit of the others.
// Springs along the surfaces remember, whoever came and went in between.
TEST(World, BodiesAsParticlesComeAndGo) {
  Scene scene = ground_scene();
  scene.gravity = {1, 0, -9.81};
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.dt = 0.001;
  scene.particles = ParticleSettings{.radius = 0.1, .stiffness = 4000, .shear_stiffness = 2000};
  World alone(scene, in_double()), busy(scene, in_double());
  const BodyHandle box = alone.add(box_at({0, 0, 0.6})), same = busy.add(box_at({0, 0, 0.6}));
  const BodyHandle guest = busy.add(ball_at({40, 0, 1}));
  for (int i = 0; i < 200; ++i) {
    alone.step();
    busy.step();
    if (i == 10) busy.add(box_at({-40, 0, 2}));
    if (i == 30) busy.remove(guest);
    ASSERT_EQ(alone.pose(box).position, busy.pose(same).position) << i;
    ASSERT_EQ(alone.velocity(box).linear, busy.velocity(same).linear) << i;
  }
  EXPECT_NEAR(alone.pose(box).position[2], 0.5, 0.05) << "on the floor";
}

TEST(World, AnEmptyWorldIsFilledAndEmptiedAgain) {
  World world(Scene{}, {.device = "reference"});
  EXPECT_EQ(refusal([&] { world.step(); }), "world: has no bodies; add one");
  const BodyHandle ball = world.add(ball_at({0, 0, 5}));
  world.step();
  world.remove(ball);
  EXPECT_EQ(refusal([&] { world.step(); }), "world: has no bodies; add one");
  world.add(ball_at({0, 0, 5}));
  world.step();
}

// ---- bodies that are put elsewhere

// From there it falls as any body does that is let go with that velocity; who lay on it falls, too, and none else
// moves.
TEST(World, PutsABodyElsewhere) {
  World world(ground_scene(), in_double());
  const BodyHandle lower = world.add(box_at({0, 0, 0.5})), upper = world.add(box_at({0, 0, 1.5}));
  const BodyHandle far = world.add(box_at({20, 0, 0.5}));
  world.step(50);
  const Pose still = world.pose(far);
  world.teleport(lower, {.position = {5, 0, 30}}, {.linear = {1, 0, 2}, .angular = {0, 0, 3}});
  EXPECT_EQ(world.pose(lower).position, (Vector3{5, 0, 30}));
  EXPECT_EQ(world.velocity(lower).linear, (Vector3{1, 0, 2}));
  EXPECT_EQ(world.steps_done(), 50u);
  world.step(20);  // 0.2 s in 100 sub-steps: z falls by g t^2 / 2 (1 + 1/100)
  EXPECT_NEAR(world.pose(lower).position[0], 5.2, 1e-12);
  EXPECT_NEAR(world.pose(lower).position[2], 30 + 2 * 0.2 - 0.5 * 9.81 * 0.04 * 1.01, 1e-9);
  EXPECT_NEAR(world.velocity(lower).angular[2], 3, 1e-12);
  EXPECT_NEAR(world.pose(upper).position[2], 1.5 - 0.5 * 9.81 * 0.04 * 1.01, 2e-3);
  EXPECT_LT(exact::length(exact::subtract(world.pose(far).position, still.position)), 1e-6);
}

TEST(World, PutsImmovableBodiesElsewhere) {
  Scene scene = ground_scene();
  World world(scene, in_double());
  BodyDescription table = box_at({0, 0, 5});
  table.kind = BODY_STATIC, table.mass = 0, table.inertia = {0, 0, 0};
  const BodyHandle fixed = world.add(table), box = world.add(box_at({0, 0, 6}));
  world.step(20);
  EXPECT_NEAR(world.pose(box).position[2], 6, 2e-3);
  world.teleport(fixed, {.position = {0, 9, 5}});
  world.step(20);
  EXPECT_NEAR(world.pose(box).position[2], 6 - 0.5 * 9.81 * 0.04 * 1.01, 2e-3);
  EXPECT_EQ(refusal([&] {
              world.teleport(fixed, {}, {.linear = {1, 0, 0}});
            }),
            "body with the handle 1: is static and does not move");
  EXPECT_EQ(refusal([&] { world.teleport(box, {{0, 0, 0}, {0, 0, 0, 2}}); }), "orientation: must be a unit quaternion");
}

// ---- the same everywhere

// All that can be done to a world, in some order.
std::uint64_t eventful_life(const WorldOptions& options) {
  Scene scene = ground_scene();
  scene.settings.events = true;
  World world(scene, options);
  std::vector<BodyHandle> boxes;
  BodyDescription lift = box_at({4, 0, 0.2});
  lift.kind = BODY_KINEMATIC, lift.mass = 0, lift.inertia = {0, 0, 0};
  const BodyHandle platform = world.add(lift);
  std::uint64_t all = 0;
  for (int i = 0; i < 60; ++i) {
    if (i % 6 == 0)
      boxes.push_back(world.add(i % 4 == 0 ? box_at({0.1 * (i % 5), 0, 3}) : ball_at({0.2, 0.1 * (i % 3), 3})));
    if (i == 20)
      world.set_load(boxes[0], [](double t) -> Wrench { return {.force = {30 * t, 0, 0}, .torque = {0, 1, t}}; });
    if (i % 7 == 3)
      world.apply_impulse(boxes.back(), {0.5, 1, 2}, exact::add(world.pose(boxes.back()).position, {0.1, 0.2, 0}));
    if (i == 40) world.remove(boxes[1]);
    if (i == 50) world.teleport(boxes[2], {.position = {-3, 0.1, 2}}, {.linear = {1, 0, 0}});
    for (const std::optional<BodyHit>& hit : world.cast_rays(std::vector<BodyRay>(3, {{0.1, 0.1, 9}, {0, 0.01, -1}})))
      if (hit) all = all * 31 + static_cast<std::uint64_t>(hit->distance * 1e6);
    world.set_kinematic_target(
        platform, {{4 - 0.03 * i, 0, 0.2}, exact::rotation({0, 0, 1}, std::sin(0.01 * i), std::cos(0.01 * i))});
    world.step();
    all = all * 31 + world.state_hash();
  }
  return all;
}

TEST(World, AnEventfulLifeHasTheSameBitsOnTheDevice) {
  for (const char* precision : {"float", "double"}) {
    const std::uint64_t on_reference = eventful_life({.device = "reference", .precision = precision});
    EXPECT_EQ(eventful_life({.device = "reference", .precision = precision}), on_reference);
    EXPECT_EQ(eventful_life({.device = "cpu", .precision = precision}), on_reference) << precision;
  }
}

// ---- what makes no sense

TEST(World, RefusesInvalidArguments) {
  World world(ground_scene(), in_double());
  const BodyHandle floor = *world.find("floor"), box = world.add(box_at({0, 0, 1}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  BodyDescription bad = box_at({0, 0, 5});
  bad.mass = 0;
  EXPECT_EQ(refusal([&] { world.add(bad); }), "body: must have a mass > 0; make_solid() gives it that of its shapes");
  bad = box_at({0, 0, 5});
  bad.name = "slab", bad.inertia = {1, 1, 3};
  EXPECT_EQ(refusal([&] { world.add(bad); }), "body \"slab\": breaks the triangle inequality of real inertias");
  bad = box_at({0, 0, 5});
  bad.shapes[0].material = 7;
  EXPECT_EQ(refusal([&] { world.add(bad); }), "body: has a material that the scene does not");
  bad = box_at({0, 0, 5});
  bad.shapes[0].kind = SHAPE_PLANE;
  EXPECT_EQ(refusal([&] { world.add(bad); }), "body: has a plane, and only static and kinematic bodies may");
  EXPECT_EQ(refusal([&] {
              world.apply_impulse(floor, {1, 0, 0});
            }),
            "body \"floor\": is not dynamic, nothing from outside moves it; give it a velocity");
  EXPECT_EQ(refusal([&] {
              world.apply(box, {.force = {nan, 0, 0}});
            }),
            "body with the handle 1: must be finite and fit double, is nan");
  EXPECT_EQ(refusal([&] { world.set_kinematic_target(box, {}); }),
            "body with the handle 1: is not kinematic; only such bodies go where they are told");
  EXPECT_EQ(refusal([&] { world.set_velocity(floor, {}); }), "body \"floor\": is static and does not move");
  EXPECT_EQ(refusal([&] { load_table({}); }), "load table: has no rows");
  EXPECT_EQ(refusal([&] { load_table({{1, {}}, {1, {}}}); }), "load table, row 1: times must rise");
  EXPECT_EQ(refusal([&] { World(ground_scene(), {.device = "reference", .precision = "half"}); }),
            "settings.precision: must be float or double, is half");
  EXPECT_EQ(refusal([&] { world.pose(BodyHandle{}); }), "body with the handle 4294967295: is not in this world");
  World other(ground_scene(), {.device = "reference"});
  EXPECT_EQ(refusal([&] { world.pose(other.bodies()[0]); }), "body with the handle 0: is of another world");
  EXPECT_FALSE(world.contains(other.bodies()[0]));
  EXPECT_TRUE(world.contains(BodyHandle{0}));
  EXPECT_EQ(world.bodies()[0], BodyHandle{0});
  EXPECT_NE(world.bodies()[0], other.bodies()[0]);
  world.step();  // and is none the worse
}

}  // namespace
}  // namespace lockstep::world_test
