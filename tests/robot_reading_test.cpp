// What URDF files say that cannot be taken as it stands: left out, mended or replaced, and told.
#include "host/scene/robot_reading.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "host/report/joints.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/scene/real_inertia.hpp"
#include "tests/recording_scene.hpp"
#include "tests/robots.hpp"

namespace lockstep::robot_reading_test {
namespace {

using RobotReadings = Robots;
using Lines = std::vector<std::string>;

Scene alone(const std::string& inside, const RobotReading& reading = {}) {
  return parse_scene(robot(inside), "robot.urdf", 0, reading);
}

TEST_F(RobotReadings, WhatNothingUsesIsCountedAndTold) {
  const std::string text = link("a", unit_inertial + "<sensor/><visual/>") + "<transmission/><gazebo><b/></gazebo>" +
                           "<transmission/><mujoco/><material name=\"red\"/>" +
                           R"(<link name="b" kind="x"><inertial><mass value="1" unit="kg"/>
                              <inertia ixx="1" iyy="1" izz="1"/></inertial></link>)" +
                           joint("continuous", "a", "b", "<calibration/>");
  EXPECT_EQ(alone(text).notes,
            (Lines{"left out: 2 x `transmission`, 1 x `gazebo`, 1 x `mujoco`, 1 x `sensor`, 1 x `link kind`, "
                   "1 x `mass unit`, 1 x `calibration`"}));
  EXPECT_EQ(lockstep::refusal([&] { alone(text, {.strict = true}); }),
            "robot.urdf:3: <transmission>: is not simulated: it would be left out (--strict)");
  EXPECT_TRUE(alone(link("a")).notes.empty());
  EXPECT_EQ(scene_of(robot(link("a") + "<gazebo/>")).notes, Lines{"robot.urdf: left out: 1 x `gazebo`"});
}

std::string inertial_of(const std::string& moments, const std::string& center = "0 0 0") {
  return "<inertial><origin xyz=\"" + center + "\"/><mass value=\"1\"/><inertia " + moments + "/></inertial>";
}

MassProperties solid_of(const std::array<double, 6>& inertia, const Vector3& center = {0, 0, 0}) {
  return {1, center, inertia};
}

void expect_inertia(const MassProperties& found, const std::array<double, 6>& expected) {
  for (unsigned i = 0; i < 6; ++i) EXPECT_NEAR(found.inertia[i], expected[i], 1e-14) << i;
}

// On the face where one moment is the sum of the others each gives a third of what is too much; on an edge two are
// equal and one is 0, which is then raised to a thousandth of them.
TEST_F(RobotReadings, TheNearestInertiaThatABodyHasIsTaken) {
  expect_inertia(nearest_real(solid_of({1, 1, 3, 0, 0, 0})), {4.0 / 3, 4.0 / 3, 8.0 / 3, 0, 0, 0});
  expect_inertia(nearest_real(solid_of({1, 3, 1, 0, 0, 0})), {4.0 / 3, 8.0 / 3, 4.0 / 3, 0, 0, 0});
  expect_inertia(nearest_real(solid_of({2, 2, 0, 0, 0, 0})), {2, 2, 0.002, 0, 0, 0});
  expect_inertia(nearest_real(solid_of({4, -3, 0, 0, 0, 0})), {2, 0.002, 2, 0, 0, 0});
  expect_inertia(nearest_real(solid_of({0, 0, 0, 0, 0, 0}, {0, 0.5, 0})), {2.5e-5, 2.5e-5, 2.5e-5, 0, 0, 0});
  expect_inertia(nearest_real(solid_of({-1, -1, -1, 0, 0, 0})), {1e-6, 1e-6, 1e-6, 0, 0, 0});
  // principal moments 3, 1, -1 about axes that are rotated by 45 degrees: 2, 0.002, 2 are nearest
  expect_inertia(nearest_real(solid_of({1, 1, 1, 2, 0, 0})), {1.001, 1.001, 2, 0.999, 0, 0});
  EXPECT_TRUE(is_real(solid_of({1, 1, 2.001, 0, 0, 0})));
  EXPECT_FALSE(is_real(solid_of({1, 1, 2.003, 0, 0, 0})));
  EXPECT_FALSE(is_real(solid_of({1, 1, 0, 0, 0, 0})));
  EXPECT_EQ(alone(link("a", inertial_of(R"(ixx="1" iyy="1" izz="3")"))).notes,
            Lines{"inertia that no body has, and the nearest one is taken: \"a\""});
}

double coordinate_after(const Scene& scene, u32 steps) {
  const InitialState<double> state = compile<double>(scene);
  Simulation<double> simulation = simulation_of(state);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  return measure_joint(simulation.backend().download(measured_buffers(state.features)), simulation.params(), 0)
      .coordinate;
}

// From the level a quarter of a period is K(1/2) sqrt(L / g), the complete elliptic integral K = 1.854074677: 0.418583
// s at L = 0.5 m. At 0.418 s it lacks (0.418583 - 0.418) sqrt(2 g / L) rad of the bottom.
TEST_F(RobotReadings, APointMassWithoutInertiaIsTheSimplePendulum) {
  const Scene scene = alone(link("world", "") + link("bob", inertial_of(R"(ixx="0" iyy="0" izz="0")", "0.5 0 0")) +
                            joint("continuous", "world", "bob", R"(<axis xyz="0 1 0"/>)"));
  EXPECT_EQ(scene.settings.dt, 0.002);
  EXPECT_NEAR(coordinate_after(scene, 209), exact::pi / 2 - 0.000583 * std::sqrt(2 * 9.81 / 0.5), 5e-3);
}

TEST_F(RobotReadings, ARootWithoutMassStaysWhereItIs) {
  const std::string ball = R"(<collision><geometry><sphere radius="0.1"/></geometry></collision>)";
  const Scene scene = alone(link("base", ball) + link("a") + joint("continuous", "base", "a"));
  EXPECT_EQ(scene.bodies.at(0).kind, BODY_STATIC);
  EXPECT_EQ(scene.notes, Lines{"without mass at the root, and fixed to the world: \"base\""});
  const Scene frame = alone(link("base", "") + link("a") + joint("fixed", "base", "a"));
  EXPECT_EQ(frame.bodies.at(0).kind, BODY_DYNAMIC) << "a frame that is fixed to a mass is part of it";
  EXPECT_TRUE(frame.notes.empty());
}

TEST_F(RobotReadings, LinksWithoutMassAreFixedToWhatTheyHangOn) {
  const std::string limit = R"(<limit lower="-1" upper="1"/>)";
  const Scene scene =
      alone(link("a") + link("b", "") + link("c", "") + link("d", "") + joint("revolute", "a", "b", limit) +
            joint("continuous", "b", "c") + joint("fixed", "c", "d"));
  EXPECT_EQ(scene.bodies.size(), 1u);
  EXPECT_TRUE(scene.joints.empty());
  EXPECT_EQ(scene.notes, Lines{"without mass, and fixed to what they hang on: \"c\", \"b\""});
}

// Mass and moments at load stay those of the file.
TEST_F(RobotReadings, ALinkWithoutMassBetweenTwoJointsTakesAShare) {
  const Scene scene =
      alone(link("world", "") + link("cross", "") + link("a", inertial_of(R"(ixx="1" iyy="1.5" izz="2")", "0 0 3")) +
            joint("continuous", "world", "cross", R"(<axis xyz="1 0 0"/>)") +
            joint("continuous", "cross", "a", R"(<origin xyz="0 1 0"/><axis xyz="0 1 0"/>)"));
  ASSERT_EQ(scene.bodies.size(), 2u);
  EXPECT_NEAR(scene.bodies[0].mass, 0.05, 1e-15);
  EXPECT_NEAR(scene.bodies[1].mass, 0.95, 1e-15);
  EXPECT_NEAR(scene.bodies[0].inertia[2] + scene.bodies[1].inertia[2], 2, 1e-14);
  for (const BodyDescription& body : scene.bodies) EXPECT_EQ(body.position, (Vector3{0, 1, 3}));
  EXPECT_EQ(scene.notes, Lines{"without mass between two joints, with 5 % of what hangs from them: \"cross\""});
}

TEST_F(RobotReadings, NumbersMayHaveCommasBetweenThem) {
  const Scene scene = alone(link("a", inertial_of(R"(ixx="1" iyy="1" izz="1")", "1, 2,3")));
  EXPECT_EQ(scene.bodies.at(0).position, (Vector3{1, 2, 3}));
}

TEST_F(RobotReadings, SphericalJointsAreBalls) {
  const Scene scene = alone(link("a") + link("b") + joint("spherical", "a", "b"));
  EXPECT_EQ(scene.joints.at(0).kind, JOINT_BALL);
}

// It would leap there in the first step.
TEST_F(RobotReadings, JointsBeyondTheirLimitsStartOnThem) {
  const Scene scene = alone(link("a") + link("b") + link("c") + joint("revolute", "a", "b", R"(<origin xyz="1 0 0"/>
      <axis xyz="0 0 1"/><limit lower="0.5" upper="1" effort="1" velocity="1"/>)") +
                            joint("prismatic", "a", "c", R"(<axis xyz="0 1 0"/>
      <limit lower="-3" upper="-2" effort="1" velocity="1"/>)"));
  EXPECT_EQ(scene.notes, Lines{"starts on the nearest of its limits: 2 of 2 joints, \"a_b\", \"a_c\""});
  EXPECT_NEAR(scene.bodies.at(1).orientation[2], std::sin(0.25), 1e-15);
  EXPECT_EQ(scene.bodies.at(2).position, (Vector3{0, -2, 0}));
  Simulation<double> simulation = simulation_of(compile<double>(scene));
  simulation.step();
  const JointMeasures hinge = measure_joint(
      simulation.backend().download(measured_buffers(compile<double>(scene).features)), simulation.params(), 0);
  EXPECT_NEAR(hinge.coordinate, 0.5, 1e-6);
  EXPECT_NEAR(hinge.speed, 0, 1e-6);
}

TEST_F(RobotReadings, PackagesAndFilesAreFound) {
  std::filesystem::create_directories(folder_.file("elsewhere/arm/meshes"));
  std::ofstream(folder_.file("elsewhere/arm/meshes/wedge.obj"))
      << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n";
  const std::string text = robot(link("a", unit_inertial +
                                               R"(<collision><geometry><mesh filename="package://arm/meshes/WEDGE.OBJ"/>
                                                  </geometry></collision>)"));
  const std::string file = folder_.file("robot.urdf");
  const auto points = [&](const RobotReading& reading) {
    return parse_scene(text, file, 0, reading).bodies.at(0).shapes.at(0).points.size();
  };
  EXPECT_NE(lockstep::refusal([&] { points({}); }), "accepted");
  EXPECT_EQ(points({.packages = {{"arm", folder_.file("elsewhere/arm")}}}), 4u);
  const std::string folders = "/nowhere:" + folder_.file("elsewhere");
  ::setenv("ROS_PACKAGE_PATH", folders.c_str(), 1);
  EXPECT_EQ(points({}), 4u);
  ::setenv("ROS_PACKAGE_PATH", folder_.file("elsewhere/arm").c_str(), 1);
  EXPECT_EQ(points({}), 4u) << "a folder may be the package itself";
  ::unsetenv("ROS_PACKAGE_PATH");
}

}  // namespace
}  // namespace lockstep::robot_reading_test
