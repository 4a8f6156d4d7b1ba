// Who is in balance sleeps, whoever holds it or nobody, and what accelerates, drifts or swings does not: against closed
// forms, by every solver that lets bodies sleep.
#include <gtest/gtest.h>

#include "tests/library_worlds.hpp"
#include "tests/sleeping_scenes.hpp"

namespace lockstep::test::balance_test {
namespace {

struct Method {
  const char *solver, *precision;
  u32 substeps;
};

std::vector<Method> methods(const std::vector<u32>& substeps = {1, 4, 5, 12}) {
  std::vector<Method> all;
  for (const char* solver : {"small_steps", "gauss_seidel", "jacobi", "dense_gauss_seidel"})
    for (const char* precision : {"float", "double"})
      for (const u32 count : substeps) all.push_back({solver, precision, count});
  return all;
}

World world_of(const Method& method, const Vector3& gravity, const std::string& bodies, double friction = 0.5,
               const std::string& more = "") {
  Scene scene = parse_scene(R"({"settings": {"sleeping": true, "solver": ")" + std::string(method.solver) +
                                R"(", "substeps": )" + std::to_string(method.substeps) +
                                R"(}, "materials": [{"name": "stuff"}], "bodies": [{"type": "static",
                                "shapes": [{"type": "plane"}]}, )" +
                                bodies + "]" + more + "}",
                            "x.json");
  scene.gravity = gravity;
  scene.materials[0].friction = friction;
  return World(scene, {.device = "reference", .precision = method.precision});
}

std::string text(const Method& method) {
  return std::string(method.solver) + ", " + method.precision + ", " + std::to_string(method.substeps);
}

constexpr double dt = 1.0 / 60;
const std::string large_ball = R"({"mass": 1, "position": [0, 0, 30], "shapes": [{"type": "sphere", "radius": 1}])";
const std::string crate = R"({"mass": 1000, "position": [0, 0, 0.5], "shapes": [{"type": "box", "size": [1, 1, 1]}]})";

std::function<Wrench(double)> constant(const Wrench& wrench) {
  return [wrench](double) { return wrench; };
}

// z = 30 - g t^2 / 2, with the error of a step of first order, g t dt / 2, and what the height is rounded by.
TEST(Balance, WhatFallsUnderTheWeakestGravityGoesOnFalling) {
  for (const Method& method : methods()) {
    const double rounding = std::string(method.precision) == "float" ? 1200 * method.substeps * 0x1p-20 : 0;
    for (const double g : {0.01, 1e-3, 1e-4}) {
      World world = world_of(method, {0, 0, -g}, large_ball + "}");
      world.step(1200);
      EXPECT_NEAR(world.poses()[1].position[2], 30 - 0.5 * g * 400, 0.5 * g * 20 * dt + 1e-6 + rounding)
          << text(method) << ", " << g;
    }
  }
}

// Up and back: it is slow for seconds about the top.
TEST(Balance, WhatIsThrownUpUnderAWeakGravityComesDown) {
  for (const Method& method : methods()) {
    World world = world_of(method, {0, 0, -0.01}, large_ball + R"(, "velocity": [0, 0, 0.1]})");
    world.step(1200);
    EXPECT_NEAR(world.poses()[1].position[2], 30, 0.5 * 0.01 * 20 * dt + 1e-4) << text(method);
  }
}

TEST(Balance, WhatDriftsWithoutGravityGoesOn) {
  for (const Method& method : methods()) {
    for (const double speed : {5e-3, 1e-4}) {
      World world = world_of(method, {0, 0, 0}, large_ball + R"(, "velocity": [)" + std::to_string(speed) + ", 0, 0]}");
      world.step(1200);
      EXPECT_NEAR(world.poses()[1].position[0], 20 * speed, 2e-5) << text(method) << speed;
      World rotating =
          world_of(method, {0, 0, 0}, large_ball + R"(, "angular_velocity": [0, 0, )" + std::to_string(speed) + "]}");
      rotating.step(1200);
      EXPECT_NEAR(rotating.poses()[1].orientation[2], std::sin(10 * speed), 2e-5) << text(method) << speed;
    }
  }
}

// In space, and on ice: 1 N on 1,000 kg makes 1.8 m in a minute, 0.1 N a tenth. A first step of rest is g t dt / 2.
TEST(Balance, ASmallForceMovesALargeMass) {
  for (const Method& method : methods({1, 5})) {
    for (const double gravity : {0.0, 9.81}) {
      for (const double force : {1.0, 0.1}) {
        World world = world_of(method, {0, 0, -gravity}, crate, 0);
        world.set_load(world.bodies()[1], constant({.force = {force, 0, 0}}));
        world.step(3600);
        EXPECT_NEAR(world.poses()[1].position[0], 1.8 * force, 5e-3 * force)
            << text(method) << ", " << gravity << ", " << force;
      }
    }
  }
}

// 0.1 N m about 1,000 / 6 kg m^2: 6e-4 rad/s^2, 0.12 rad in 20 s.
TEST(Balance, ASmallTorqueRotatesALargeMass) {
  for (const Method& method : methods()) {
    for (const double torque : {0.1, 0.01}) {
      World world = world_of(method, {0, 0, 0}, crate);
      world.set_load(world.bodies()[1], constant({.torque = {0, 0, torque}}));
      world.step(1200);
      const double angle = 0.5 * torque / (1000.0 / 6) * 400;
      EXPECT_NEAR(2 * std::asin(world.poses()[1].orientation[2]), angle, 2e-3 * angle + 2e-5) << text(method) << torque;
    }
  }
}

// x = A cos(w t), w^2 = g l / (l^2 + 2/5 r^2), of a bob that is slow all the time, and never where it was for long.
TEST(Balance, APendulumGoesOnWhereItReverses) {
  const double length = 25, amplitude = 0.05, omega = std::sqrt(9.81 * length / (length * length + 0.4));
  for (const Method& method : methods({1, 5})) {
    World world = world_of(method, {0, 0, -9.81},
                           R"({"name": "bob", "mass": 1, "position": [0.05, 0, 30], "shapes": [
                               {"type": "sphere", "radius": 1}]})",
                           0.5, R"(, "joints": [{"type": "ball", "bodies": ["world", "bob"], "anchor": [0, 0, 55]}])");
    for (u32 k = 1; k <= 40; ++k) {
      world.step(30);
      ASSERT_FALSE(world.is_asleep(world.bodies()[1])) << text(method) << ", " << k;
      EXPECT_NEAR(world.poses()[1].position[0], amplitude * std::cos(omega * 0.5 * k), 0.06 * amplitude)
          << text(method) << ", " << k;
    }
  }
}

// Without gravity and at rest it needs no support to sleep.
TEST(Balance, WhatIsAtRestInSpaceSleeps) {
  for (const Method& method : methods()) {
    World world = world_of(method, {0, 0, 0}, large_ball + "}");
    world.step(40);
    EXPECT_TRUE(world.is_asleep(world.bodies()[1])) << text(method);
  }
}

// A balloon that lifts what it weighs sleeps in mid-air, and rises by what it lifts more: 1e-3 m/s^2.
TEST(Balance, ABalloonInBalanceSleepsUntilItsLiftChanges) {
  for (const Method& method : methods()) {
    World world = world_of(method, {0, 0, -9.81}, large_ball + "}");
    const BodyHandle balloon = world.bodies()[1];
    world.set_load(balloon, [](double time) -> Wrench { return {.force = {0, 0, time < 1 ? 9.81 : 9.811}}; });
    world.step(60);
    EXPECT_TRUE(world.is_asleep(balloon)) << text(method);
    EXPECT_NEAR(world.poses()[1].position[2], 30, 1e-5) << text(method);
    world.step(600);
    EXPECT_FALSE(world.is_asleep(balloon)) << text(method);
    EXPECT_NEAR(world.poses()[1].position[2], 30.05, 5e-4) << text(method);
  }
}

// In one sub-step of one sweep small_steps sinks into its springs by 0.4 mm, and takes half a second more.
TEST(Balance, UprightBodiesSleepWithinASecond) {
  const std::pair<const char*, const char*> standing[] = {
      {"cylinder", R"({"mass": 0.1, "position": [0, 0, 0.05],
                       "shapes": [{"type": "cylinder", "radius": 0.02, "length": 0.1}]})"},
      {"bottle", R"({"mass": 0.7, "position": [0, 0, 0.1], "shapes": [
                     {"type": "cylinder", "radius": 0.035, "length": 0.2},
                     {"type": "cylinder", "radius": 0.013, "length": 0.1, "offset": [0, 0, 0.15]}]})"},
      {"pillar", R"({"mass": 10, "position": [0, 0, 0.5], "shapes": [{"type": "box", "size": [0.1, 0.1, 1]}]})"}};
  for (const Method& method : methods()) {
    const bool one_sweep = std::string(method.solver) == "small_steps" && method.substeps == 1;
    for (const auto& [name, body] : standing) {
      World world = world_of(method, {0, 0, -9.81}, body);
      const double height = world.poses()[1].position[2];
      world.step(one_sweep ? 90 : 60);
      EXPECT_TRUE(world.is_asleep(world.bodies()[1])) << name << ", " << text(method);
      EXPECT_NEAR(world.poses()[1].position[2], height, 2e-3 * height + (one_sweep ? 5e-4 : 0))
          << name << ", " << text(method);
      EXPECT_NEAR(std::abs(world.poses()[1].orientation[3]), 1, 1e-5) << name << ", " << text(method);
    }
  }
}

// tan 20 deg < 0.5: it stays where friction holds it.
TEST(Balance, WhatRestsOnASlopeByFrictionSleeps) {
  const double angle = 20 * std::numbers::pi / 180;
  for (const Method& method : methods()) {
    World world = world_of(method, {9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)}, crate);
    world.step(90);
    EXPECT_TRUE(world.is_asleep(world.bodies()[1])) << text(method);
    EXPECT_NEAR(world.poses()[1].position[0], 0, 5e-3) << text(method);
  }
}

// a t^2 / 2, from rest, while it settles onto the ice.
TEST(Balance, WhatSlidesOnIceFromRestGoesOn) {
  for (const Method& method : methods()) {
    for (const double acceleration : {0.02, 1e-3}) {
      World world = world_of(method, {acceleration, 0, -9.81}, crate, 0);
      world.step(600);
      EXPECT_FALSE(world.is_asleep(world.bodies()[1])) << text(method) << ", " << acceleration;
      EXPECT_NEAR(world.poses()[1].position[0], 50 * acceleration, 0.5 * acceleration * 10 * dt + 2e-4)
          << text(method) << ", " << acceleration;
    }
  }
}

// Pushed at 1 mm/s, it goes along; it sleeps when the pusher has stopped, and not before.
TEST(Balance, ACrateThatIsPushedSlowlyGoesAlong) {
  for (const Method& method : methods({1, 5})) {
    World world = world_of(method, {0, 0, -9.81},
                           crate + R"(, {"type": "kinematic", "position": [-1, 0, 0.5], "velocity": [0.001, 0, 0],
                                     "shapes": [{"type": "box", "size": [1, 0.5, 0.5]}]})");
    const BodyHandle box = world.bodies()[1], pusher = world.bodies()[2];
    for (u32 k = 0; k < 120; ++k) {
      world.step(10);
      ASSERT_FALSE(world.is_asleep(box)) << text(method) << ", " << k;
    }
    EXPECT_NEAR(world.pose(box).position[0], 0.02, 1e-3) << text(method);
    world.set_velocity(pusher, {});
    world.step(90);
    EXPECT_TRUE(world.is_asleep(box)) << text(method);
  }
}

// What lies on a plate that tilts by 0.01 rad/s has its orientation.
TEST(Balance, WhatLiesOnAPlateThatTiltsSlowlyTilts) {
  for (const Method& method : methods({1, 5})) {
    World world =
        world_of(method, {0, 0, -9.81},
                 R"({"mass": 1, "position": [0, 0, 2.1], "shapes": [{"type": "box", "size": [0.2, 0.2, 0.2]}]},
                              {"type": "kinematic", "position": [0, 0, 1.9], "angular_velocity": [0, 0.01, 0],
                               "shapes": [{"type": "box", "size": [2, 2, 0.2]}]})");
    for (u32 k = 0; k < 60; ++k) {
      world.step(10);
      ASSERT_FALSE(world.is_asleep(world.bodies()[1])) << text(method) << ", " << k;
    }
    EXPECT_NEAR(2 * std::asin(world.poses()[1].orientation[1]), 0.1, 2e-3) << text(method);
  }
}

// Let go at any step about that in which it would have fallen asleep: it falls.
TEST(Balance, WhatLosesItsSupportUnderAWeakGravityFalls) {
  for (const u32 supported : {25u, 27u, 28u, 29u, 30u, 31u, 45u, 58u, 59u, 60u, 61u}) {
    World world = world_of({"small_steps", "float", 4}, {0, 0, -0.01},
                           R"({"mass": 1, "position": [0, 0, 20], "shapes": [{"type": "box", "size": [2, 2, 2]}]},
                              {"type": "static", "position": [0, 0, 18], "shapes": [{"type": "box", "size": [2, 2, 2]}]})");
    world.step(supported);
    world.remove(world.bodies()[2]);
    world.step(600);
    EXPECT_NEAR(world.poses()[1].position[2], 20 - 0.5 * 0.01 * 100, 2e-3) << supported;
  }
}

// A load that changes wakes; the first one does, too.
TEST(Balance, AChangedLoadWakes) {
  World world = world_of({"small_steps", "float", 4}, {0, 0, 0}, large_ball + "}");
  world.step(60);
  const BodyHandle ball = world.bodies()[1];
  ASSERT_TRUE(world.is_asleep(ball));
  world.apply(ball, {.force = {1e-3, 0, 0}});
  world.step();
  EXPECT_FALSE(world.is_asleep(ball));
}

// A push so late that it can make no way before the ball would fall asleep.
TEST(Balance, WhatIsPushedJustBeforeItWouldSleepDriftsOn) {
  for (const u32 rested : {26u, 27u, 28u, 29u, 30u}) {
    World world = world_of({"gauss_seidel", "float", 1}, {0, 0, 0}, large_ball + "}");
    world.step(rested);
    world.apply_impulse(world.bodies()[1], {0.01, 0, 0});
    world.step(600);
    EXPECT_NEAR(world.poses()[1].position[0], 0.1, 1e-4) << rested;
  }
}

}  // namespace
}  // namespace lockstep::test::balance_test
