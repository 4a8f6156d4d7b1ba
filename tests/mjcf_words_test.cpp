// Robots from MJCF files: how a file is put together, what actuators without a control do, and what is nearly read.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "host/report/joints.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "tests/mjcf_scene.hpp"
#include "tests/recording_scene.hpp"
#include "tests/robots.hpp"

namespace lockstep::mjcf_words_test {
namespace {

using mjcf_scene::body;
using mjcf_scene::mjcf;
using mjcf_scene::world;

JointMeasures joint_after(const Scene& scene, u32 steps, const std::string& name) {
  const auto found = std::ranges::find(scene.joints, "r/" + name, &JointDescription::name);
  const InitialState<double> state = compile<double>(scene);
  Simulation<double> simulation = simulation_of(state);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  return measure_joint(simulation.backend().download(measured_buffers(state.features)), simulation.params(),
                       static_cast<u32>(found - scene.joints.begin()));
}

void expect_near(const Vector3& found, const Vector3& expected, double tolerance, const std::string& what) {
  for (unsigned i = 0; i < 3; ++i) EXPECT_NEAR(found[i], expected[i], tolerance) << what << " " << i;
}

using MjcfWords = Robots;

const std::string ball = R"(<geom size="0.1" mass="1"/>)";

TEST_F(MjcfWords, FramesMoveWhatIsInThem) {
  const Scene scene = world(R"(<frame pos="1 0 0" euler="0 0 1.5707963267948966"><body name="a" pos="1 0 0"><freejoint/>
      <frame pos="0 0 1"><geom size="0.1" mass="1"/></frame></body></frame>)");
  expect_near(body(scene, "a").position, {1, 1, 1}, 1e-15, "a quarter turn about z, and 1 m up");
}

// Each copy stands in the frame of the one before it.
TEST_F(MjcfWords, ReplicatesAreNumberedAndGoOnFromEachOther) {
  const Scene scene = world(
      "<replicate count=\"12\" sep=\"-\" offset=\"1 0 0\" euler=\"0 0 0.5\"><body name=\"b\" pos=\"0 1 0\">"
      "<freejoint/>" +
      ball + "</body></replicate>");
  ASSERT_EQ(scene.bodies.size(), 12u);
  Vector3 at = {0, 0, 0};
  for (u32 i = 0; i < 12; ++i) {
    const double angle = 0.5 * i;
    const std::string name = "b-" + std::string(i < 10 ? "0" : "") + std::to_string(i);
    expect_near(body(scene, name).position, {at[0] - std::sin(angle), at[1] + std::cos(angle), 0}, 1e-13, name);
    at = {at[0] + std::cos(angle), at[1] + std::sin(angle), 0};
  }
}

TEST_F(MjcfWords, FilesAreIncludedAndAttached) {
  std::ofstream(folder_.file("limb.xml")) << R"(<mujoco><compiler angle="radian"/><worldbody><body name="limb">
      <joint name="j" range="-1 1"/>)" + ball + R"(</body></worldbody>
      <actuator><position joint="j" kp="3"/></actuator></mujoco>)";
  std::ofstream(folder_.file("main.xml")) << R"(<mujoco model="r"><include file="rest.xml"/></mujoco>)";
  std::ofstream(folder_.file("rest.xml")) << R"(<mujoco><asset><model name="limb" file="limb.xml"/></asset><worldbody>
      <body name="a" pos="0 0 1"><freejoint/>)" + ball +
                                                 R"(
      <frame pos="1 0 0"><attach model="limb" body="limb" prefix="left_"/></frame>
      <frame pos="-1 0 0"><attach model="limb" body="limb" prefix="right_"/></frame></body></worldbody></mujoco>)";
  const Scene scene = read_scene(folder_.file("main.xml"));
  ASSERT_EQ(scene.bodies.size(), 3u);
  EXPECT_EQ(body(scene, "left_limb").position, (Vector3{1, 0, 1}));
  EXPECT_EQ(body(scene, "right_limb").position, (Vector3{-1, 0, 1}));
  EXPECT_EQ(scene.joints[0].name, "r/left_j");
  EXPECT_EQ(scene.joints[0].low, -1);
  EXPECT_EQ(scene.joints[1].spring ? scene.joints[1].spring->stiffness : 0, 3);
  std::ofstream(folder_.file("main.xml")) << R"(<mujoco><include file="rest.xml"/><include file="rest.xml"/></mujoco>)";
  EXPECT_NE(lockstep::refusal([&] { read_scene(folder_.file("main.xml")); }).find("includes \"rest.xml\" again"),
            std::string::npos);
}

Scene driven(const std::string& actuator, const std::string& more = "") {
  return world(R"(<body name="a"><joint name="j" axis="0 1 0"/><geom size="0.1" mass="1" pos="0.5 0 0"/></body>)",
               more + "<actuator>" + actuator + "</actuator>");
}

void expect_servo(const Scene& scene, double stiffness, double damping, double rest) {
  ASSERT_EQ(scene.joints.size(), 1u);
  ASSERT_TRUE(scene.joints[0].spring);
  EXPECT_NEAR(scene.joints[0].spring->stiffness, stiffness, 1e-15 * stiffness);
  EXPECT_NEAR(scene.joints[0].spring->damping, damping, 1e-15 * damping);
  EXPECT_NEAR(scene.joints[0].spring->rest, rest, 1e-15);
}

// force = gain control + bias, and the control is what of its range is nearest to 0.
TEST_F(MjcfWords, AnActuatorWithoutAControlIsAServo) {
  expect_servo(driven(R"(<general joint="j" gainprm="20" biastype="affine" biasprm="10 -20 -1.5"/>)"), 20, 1.5, 0.5);
  expect_servo(driven(R"(<position joint="j" kp="100" kv="4" ctrlrange="-2.7 -0.8"/>)"), 100, 4, -0.8);
  expect_servo(driven(R"(<position joint="j" kp="100" kv="4" ctrlrange="-2.7 -0.8"/>)",
                      R"(<option><flag clampctrl="disable"/></option>)"),
               100, 4, 0);
  expect_servo(driven(R"(<intvelocity joint="j" kp="7" kv="1"/>)"), 7, 1, 0);
  EXPECT_FALSE(driven(R"(<general joint="j" dyntype="filter" dynprm="0.05" gainprm="30"/>)").joints[0].spring);
  EXPECT_FALSE(
      driven(R"(<position joint="j" kp="9"/>)", R"(<option><flag actuation="disable"/></option>)").joints[0].spring);
  EXPECT_FALSE(
      driven(R"(<position joint="j" kp="9" group="2"/>)", R"(<option actuatorgroupdisable="2"/>)").joints[0].spring);
}

// The defaults of a class are those of all kinds.
TEST_F(MjcfWords, ActuatorsHaveDefaultsOfOtherKinds) {
  expect_servo(driven(R"(<position joint="j" kp="3"/>)", R"(<default><general gear="2"/></default>)"), 12, 0, 0);
  expect_servo(driven(R"(<general joint="j"/>)", R"(<default><position kp="30" kv="2"/></default>)"), 30, 2, 0);
  EXPECT_FALSE(driven(R"(<motor joint="j"/>)", R"(<default><position kp="30"/></default>)").joints[0].spring);
}

// 2 ratio sqrt(kp m): m = 1 kg at 0.5 m, and 2/5 m r^2 of the ball.
TEST_F(MjcfWords, ADampingRatioIsOfTheMassOfTheCoordinate) {
  expect_servo(driven(R"(<position joint="j" kp="4" dampratio="0.5" gear="3"/>)"), 36,
               2 * 0.5 * std::sqrt(4 * 0.254 / 9) * 9, 0);
}

// 2 kg on a slide, held by less than it needs to: (30 - 2 g) / 2 up, until the servo nears its target.
TEST_F(MjcfWords, AServoPushesWithItsForceRangeAtMost) {
  const Scene scene =
      world(R"(<body name="a"><joint name="j" type="slide" axis="0 0 1"/><geom size="0.1" mass="2"/></body>)",
            R"(<option timestep="0.0005"/><actuator>
                               <position joint="j" kp="10000" kv="200" ctrlrange="1 2" forcerange="-10 15" gear="2"/></actuator>)");
  ASSERT_EQ(scene.joints.size(), 2u);
  EXPECT_EQ(scene.joints[1].spring->forces, (std::array<double, 2>{-20, 30}));
  const double a = 15 - 9.81;
  EXPECT_NEAR(joint_after(scene, 800, "j").coordinate, 0.5 * a * 0.4 * 0.4, 1e-4);
  EXPECT_NEAR(joint_after(scene, 800, "j").speed, a * 0.4, 1e-6);
}

// Half its weight is held: it falls with g / 2, and one that is held whole stays.
TEST_F(MjcfWords, GravityCompensationSupportsWeight) {
  const Scene scene = world("<body name=\"a\" gravcomp=\"0.5\"><joint name=\"j\" type=\"slide\"/>" + ball +
                            "</body><body name=\"b\" pos=\"1 0 0\" gravcomp=\"1\"><joint name=\"k\" type=\"slide\"/>" +
                            ball + "</body>");
  EXPECT_NEAR(joint_after(scene, 100, "j").speed, -9.81 / 2 * 0.2, 1e-12);
  EXPECT_NEAR(joint_after(scene, 100, "k").speed, 0, 1e-12);
}

TEST_F(MjcfWords, MocapBodiesAreKinematic) {
  const Scene scene = world("<body name=\"m\" mocap=\"true\" pos=\"0 0 2\">" + ball +
                            "</body><body name=\"a\"><freejoint/>" + ball + "</body>");
  EXPECT_EQ(body(scene, "m").kind, BODY_KINEMATIC);
  EXPECT_EQ(body(scene, "m").position, (Vector3{0, 0, 2}));
}

// Sites that are apart at load are brought together.
TEST_F(MjcfWords, SitesAreEndsOfConstraints) {
  const Scene scene =
      world(R"(<site name="w" pos="0 0 1"/><body name="a" pos="0 0 0.9"><joint type="slide" name="j"/>)" + ball +
                R"(<site name="s" pos="0 0 0.05"/></body>)",
            R"(<equality><weld site1="s" site2="w"/></equality>)");
  ASSERT_EQ(scene.joints.size(), 2u);
  EXPECT_EQ(scene.joints[1].kind, JOINT_FIXED);
  EXPECT_NEAR(joint_after(scene, 2000, "j").coordinate, 0.05, 1e-3);
}

TEST_F(MjcfWords, FlagsSwitchOff) {
  const auto with = [](const std::string& flag) {
    return world(R"(<body name="a"><joint name="j" range="-1 1" damping="2" stiffness="3" frictionloss="1"/>)" + ball +
                     "</body>",
                 "<option><flag " + flag + "=\"disable\"/></option>");
  };
  EXPECT_TRUE(with("sensor").joints[0].limited);
  EXPECT_FALSE(with("limit").joints[0].limited);
  EXPECT_FALSE(with("constraint").joints[0].limited);
  EXPECT_EQ(with("frictionloss").joints[0].friction, 0);
  EXPECT_EQ(with("spring").joints.back().spring->stiffness, 0);
  EXPECT_EQ(with("damper").joints.back().spring->damping, 0);
  EXPECT_TRUE(with("contact").bodies[0].shapes.empty());
}

TEST_F(MjcfWords, EllipsoidsWeighWhatTheyDoAndAreHulls) {
  const Scene scene =
      world(R"(<body name="a"><freejoint/><geom type="ellipsoid" size="0.1 0.2 0.3" density="500"/></body>)");
  const double mass = 500 * 4.0 / 3.0 * exact::pi * 0.006;
  EXPECT_NEAR(body(scene, "a").mass, mass, 1e-14 * mass);
  expect_near(body(scene, "a").inertia, {0.2 * mass * 0.13, 0.2 * mass * 0.10, 0.2 * mass * 0.05}, 1e-14, "moments");
  ASSERT_EQ(body(scene, "a").shapes.at(0).kind, SHAPE_HULL);
  double highest = 0;
  for (const Vector3& p : body(scene, "a").shapes[0].points) {
    EXPECT_NEAR(p[0] * p[0] / 0.01 + p[1] * p[1] / 0.04 + p[2] * p[2] / 0.09, 1, 1e-12);
    highest = std::max(highest, p[2]);
  }
  EXPECT_EQ(highest, 0.3);
}

// A right tetrahedron: the reference pose is subtracted before the scale is applied; its centre is a quarter along.
TEST_F(MjcfWords, TheReferencePoseOfAMeshComesBeforeItsScale) {
  const Scene scene = world(R"(<body name="a" pos="0 0 1"><freejoint/><geom type="mesh" mesh="m" mass="1"/></body>)",
                            R"(<asset><mesh name="m" refpos="0.1 0 0.2" scale="1 1 2"
                               vertex="0 0 0  .3 0 0  0 .2 0  0 0 .4"/></asset>)");
  expect_near(body(scene, "a").position, {0.3 / 4 - 0.1, 0.05, 1 + 2 * (0.1 - 0.2)}, 1e-15, "centre");
}

// Its mass is on its faces: of a cube of side 1 with 1 kg, m a^2 5/18; of a solid one m a^2 / 6.
TEST_F(MjcfWords, MeshesAreSolidsOrShells) {
  const auto cube = [](const std::string& inertia) {
    return world(
        R"(<body name="a"><freejoint/><geom type="mesh" mesh="m" mass="1" contype="0" conaffinity="0"/></body>)",
        "<asset><mesh name=\"m\" inertia=\"" + inertia +
            R"(" vertex="0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1"/></asset>)");
  };
  for (const auto& [inertia, moment] :
       {std::pair("shell", 5.0 / 18), {"exact", 1.0 / 6}, {"convex", 1.0 / 6}, {"legacy", 1.0 / 6}})
    expect_near(body(cube(inertia), "a").inertia, {moment, moment, moment}, 1e-14, inertia);
}

}  // namespace
}  // namespace lockstep::mjcf_words_test
