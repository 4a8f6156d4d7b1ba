// Robots from URDF files: what becomes of links and joints.
#include "tests/robots.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "host/record/identity.hpp"
#include "host/report/joints.hpp"
#include "host/report/measures.hpp"
#include "host/scene/hull.hpp"
#include "host/scene/mass_properties.hpp"
#include "host/scene/read.hpp"
#include "tests/recording_scene.hpp"

namespace lockstep::robots_test {
namespace {

template <class real>
WorldHash hash_after(const Scene& scene, u32 steps) {
  const InitialState<real> state = compile<real>(scene);
  Simulation<real> simulation = simulation_of(state);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  return simulation.world_hashes().front();
}

// The same two rods in both languages: the same constants, the same state after 100 steps.
TEST_F(Robots, ADoublePendulumIsThatOfTheSceneFormat) {
  const std::string rod = R"(<inertial><origin xyz="0 0 -0.25"/><mass value="2"/>
      <inertia ixx="0.0625" iyy="0.0625" izz="0.001953125"/></inertial>
    <collision><origin xyz="0 0 -0.25"/><geometry><box size="0.0625 0.0625 0.5"/></geometry></collision>)";
  const std::string settings = R"(, "settings": {"integrator": "trapezoidal"})";
  const Scene urdf = scene_of(robot(link("world", "") + link("upper", rod) + link("lower", rod) +
                                    joint("continuous", "world", "upper",
                                          R"(<origin xyz="0 0 2"/><axis xyz="0 1 0"/><dynamics damping="0.125"/>)") +
                                    joint("revolute", "upper", "lower", R"(<origin xyz="0 0 -0.5"/><axis xyz="0 1 0"/>
                                          <limit lower="-2" upper="1.5" effort="1" velocity="1"/>)")),
                              "", settings);
  const Scene json = parse_scene(R"({"bodies": [
      {"name": "a", "mass": 2, "inertia": [0.0625, 0.0625, 0.001953125], "position": [0, 0, 1.75],
       "shapes": [{"type": "box", "size": [0.0625, 0.0625, 0.5]}]},
      {"name": "b", "mass": 2, "inertia": [0.0625, 0.0625, 0.001953125], "position": [0, 0, 1.25],
       "shapes": [{"type": "box", "size": [0.0625, 0.0625, 0.5]}]}],
    "joints": [
      {"type": "hinge", "bodies": ["world", "a"], "anchor": [0, 0, 2], "axis": [0, 1, 0], "spring": {"damping": 0.125}},
      {"type": "hinge", "bodies": ["a", "b"], "anchor": [0, 0, 1.5], "axis": [0, 1, 0], "limits": [-2, 1.5]}])" +
                                     settings + "}",
                                 "json.json");
  ASSERT_EQ(urdf.bodies.size(), 2u) << "a root without shapes that does not move is the fixed frame";
  EXPECT_EQ(urdf.bodies[0].name, "r/upper");
  EXPECT_EQ(urdf.joints[1].name, "r/upper_lower");
  EXPECT_EQ(identity_of(compile<float>(urdf)), identity_of(compile<float>(json)));
  EXPECT_EQ(identity_of(compile<double>(urdf)), identity_of(compile<double>(json)));
  const WorldHash a = hash_after<float>(urdf, 100), b = hash_after<float>(json, 100);
  EXPECT_EQ(a.state_high, b.state_high);
  EXPECT_EQ(a.state_low, b.state_low);
}

using Tensor = std::array<double, 6>;  // xx, yy, zz, xy, xz, yz

// R diag(moments) R^T of a body.
Tensor tensor_of(const BodyDescription& body) {
  MassProperties own;
  own.inertia = {body.inertia[0], body.inertia[1], body.inertia[2], 0, 0, 0};
  return transformed(own, {0, 0, 0}, body.orientation).inertia;
}

TEST_F(Robots, ATensorWithProductsIsRotatedToItsPrincipalAxes) {
  const Tensor given = {0.03, 0.04, 0.05, 0.002, -0.004, 0.006};
  const Scene scene = scene_of(robot(link("a", R"(<inertial><mass value="3"/><inertia ixx="0.03" iyy="0.04" izz="0.05"
      ixy="0.002" ixz="-0.004" iyz="0.006"/></inertial>
      <collision><origin xyz="1 2 3"/><geometry><sphere radius="0.1"/></geometry></collision>)")));
  const BodyDescription& body = scene.bodies.at(0);
  const Tensor found = tensor_of(body);
  for (unsigned i = 0; i < 6; ++i) EXPECT_NEAR(found[i], given[i], 1e-16) << i;
  EXPECT_NEAR(body.inertia[0] + body.inertia[1] + body.inertia[2], 0.12, 1e-15);
  const Vector3 ball = exact::rotate(body.orientation, body.shapes.at(0).offset);  // stays where it is
  for (unsigned i = 0; i < 3; ++i) EXPECT_NEAR(ball[i], i + 1.0, 1e-14);
}

TEST_F(Robots, TheOriginOfAnInertialRotatesItsTensor) {
  // a quarter turn about z: x becomes y
  const Scene scene = scene_of(robot(link("a", R"(<inertial><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>
      <mass value="3"/><inertia ixx="0.03" iyy="0.04" izz="0.05"/></inertial>)")),
                               R"(, "position": [10, 0, 0])");
  const Tensor found = tensor_of(scene.bodies.at(0));
  const Tensor expected = {0.04, 0.03, 0.05, 0, 0, 0};
  for (unsigned i = 0; i < 6; ++i) EXPECT_NEAR(found[i], expected[i], 1e-16) << i;
  EXPECT_EQ(scene.bodies[0].position, (Vector3{11, 2, 3}));
}

TEST_F(Robots, LinksFixedToEachOtherAreOneBody) {
  const auto point = [](const std::string& name) {
    return link(name, R"(<inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
      <collision><geometry><sphere radius="0.1"/></geometry></collision>)");
  };
  const Scene scene = scene_of(robot(point("a") + link("frame", "") + point("b") +
                                     joint("fixed", "a", "frame", R"(<origin xyz="0 1 0"/>)") +
                                     joint("fixed", "frame", "b", R"(<origin xyz="0 1 0"/>)")));
  ASSERT_EQ(scene.bodies.size(), 1u);
  const BodyDescription& body = scene.bodies[0];
  EXPECT_EQ(body.name, "r/a");
  EXPECT_EQ(body.mass, 4);
  EXPECT_EQ(body.position, (Vector3{0, 1, 0}));
  EXPECT_EQ(body.inertia, (Vector3{4.2, 0.2, 4.2}));  // 2 (0.1 + 2 * 1^2) across
  ASSERT_EQ(body.shapes.size(), 2u);
  EXPECT_EQ(body.shapes[0].offset, (Vector3{0, -1, 0}));
  EXPECT_EQ(body.shapes[1].offset, (Vector3{0, 1, 0}));
  EXPECT_TRUE(scene.joints.empty());
}

TEST_F(Robots, TheRootIsFreeUnlessItIsFixed) {
  const std::string ball = R"(<collision><geometry><sphere radius="0.1"/></geometry></collision>)";
  const std::string arm = link("arm") + joint("continuous", "root", "arm");
  const Scene free = scene_of(robot(link("root", unit_inertial + ball) + arm));
  EXPECT_EQ(free.bodies.at(0).kind, BODY_DYNAMIC);
  const Scene fixed = scene_of(robot(link("root", ball) + arm), R"(, "fixed": true, "position": [0, 0, 5])");
  EXPECT_EQ(fixed.bodies.at(0).kind, BODY_STATIC);
  EXPECT_EQ(fixed.bodies.at(0).position, (Vector3{0, 0, 5}));
  EXPECT_EQ(fixed.joints.at(0).body_a, 0u);
  const Scene world = scene_of(robot(link("world", ball) + link("arm") + joint("continuous", "world", "arm")));
  EXPECT_EQ(world.bodies.at(0).kind, BODY_STATIC);
  const Scene floating = scene_of(robot(link("root") + link("b") + joint("floating", "root", "b")));
  EXPECT_EQ(floating.bodies.size(), 2u);
  EXPECT_TRUE(floating.joints.empty());
}

// The coordinate of the first joint of a scene at its start, and after so many steps.
double coordinate_after(const Scene& scene, u32 steps, u32 joint = 0) {
  const InitialState<double> state = compile<double>(scene);
  if (steps == 0) return measure_joint(state.buffers, state.params, joint).coordinate;
  Simulation<double> simulation = simulation_of(state);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  return measure_joint(simulation.backend().download(measured_buffers(state.features)), simulation.params(), joint)
      .coordinate;
}

const std::string arm_along_x = R"(<inertial><origin xyz="0.5 0.1 0"/><mass value="1"/>
    <inertia ixx="0.02" ixy="0.003" iyy="0.05" izz="0.06"/></inertial>)";

TEST_F(Robots, JointsStartWhereTheSceneSays) {
  const std::string robot_text = robot(link("world", "") + link("a", arm_along_x) + link("b", arm_along_x) +
                                       joint("continuous", "world", "a", R"(<axis xyz="0 0 1"/>)") +
                                       joint("revolute", "a", "b", R"(<origin xyz="1 0 0" rpy="0.3 0.2 0.1"/>
                                          <axis xyz="0 2 0"/><limit lower="-1" upper="1"/>)"));
  const Scene started = scene_of(robot_text, R"(, "joints": [{"name": "world_a", "start_deg": 90},
                                             {"name": "a_b", "start": -0.75}])");
  EXPECT_NEAR(coordinate_after(started, 0), exact::pi / 2, 1e-12);
  EXPECT_NEAR(coordinate_after(started, 0, 1), -0.75, 1e-12);
  const Vector3 a = started.bodies.at(0).position;  // (0.5, 0.1) turned by 90 degrees
  EXPECT_NEAR(a[0], -0.1, 1e-15);
  EXPECT_NEAR(a[1], 0.5, 1e-15);
  const Scene plain = scene_of(robot_text);
  EXPECT_NEAR(coordinate_after(plain, 0, 1), 0, 1e-12);

  const Scene slid = scene_of(robot(link("world", "") + link("a", arm_along_x) +
                                    joint("prismatic", "world", "a", R"(<origin rpy="0 0 1.5707963267948966"/>
                                          <limit lower="-1" upper="2"/>)")),
                              R"(, "joints": [{"name": "world_a", "start": 0.5}])");
  EXPECT_NEAR(coordinate_after(slid, 0), 0.5, 1e-12);
  EXPECT_NEAR(slid.bodies.at(0).position[1], 1, 1e-15);  // x of the joint is y of the world
}

// From 1.5 revolutions, where the arm stands across, it falls by a quarter until a limit below two stops it.
TEST_F(Robots, AnglesCountRevolutions) {
  const std::string robot_text =
      robot(link("world", "") + link("a", arm_along_x) + joint("revolute", "world", "a", R"(<axis xyz="0 1 0"/>
                                          <limit lower="-12" upper="10"/>)"));
  const double start = 3 * exact::pi;
  const Scene scene = scene_of(robot_text, R"(, "joints": [{"name": "world_a", "start": 9.42477796076938}])");
  EXPECT_EQ(scene.joints.at(0).low, -12);
  EXPECT_NEAR(scene.bodies.at(0).position[0], -0.5, 1e-12);
  EXPECT_NEAR(coordinate_after(scene, 0), start, 1e-12);
  EXPECT_LT(coordinate_after(scene, 30), start) << "an arm along -x falls the other way about y";
  const Scene limited =
      scene_of(robot(link("world", "") + link("a", arm_along_x) + joint("revolute", "world", "a", R"(<axis xyz="0 1 0"/>
                                          <limit lower="9" upper="10"/>)")),
               R"(, "joints": [{"name": "world_a", "start": 9.42477796076938}])");
  EXPECT_NEAR(coordinate_after(limited, 300), 9, 1e-3);
}

TEST_F(Robots, LimitsAreKept) {
  const Scene scene =
      scene_of(robot(link("world", "") + link("a", arm_along_x) + joint("revolute", "world", "a", R"(<axis xyz="0 1 0"/>
                                           <limit lower="-0.5" upper="0.5"/>)")));
  EXPECT_NEAR(coordinate_after(scene, 300), 0.5, 1e-3) << "an arm along x falls by turning about y";
}

// A torque of m g l = 1 * 9.81 * 0.5 N m is what friction has to hold.
TEST_F(Robots, DryFrictionStopsAnArmThatIsLightEnough) {
  const auto with = [&](double friction) {
    return scene_of(robot(link("world", "") + link("a", arm_along_x) +
                          joint("continuous", "world", "a",
                                R"(<axis xyz="0 1 0"/><dynamics friction=")" + std::to_string(friction) + "\"/>")));
  };
  EXPECT_NEAR(coordinate_after(with(5.0), 100), 0, 1e-3);
  EXPECT_GT(coordinate_after(with(4.8), 100), 0.01);
}

TEST_F(Robots, WhatAJointHasTooMuchOfGetsAJointOfItsOwn) {
  const auto joints = [&](const std::string& type, const std::string& dynamics, const std::string& use) {
    return scene_of(robot(link("world", "") + link("a") +
                          joint(type, "world", "a", R"(<limit lower="-1" upper="1"/>)" + dynamics)),
                    use.empty() ? "" : R"(, "joints": [{"name": "world_a", )" + use + "}]")
        .joints;
  };
  EXPECT_EQ(joints("revolute", "", "").size(), 1u);
  const auto damped = joints("revolute", R"(<dynamics damping="2" friction="3"/>)", "");
  ASSERT_EQ(damped.size(), 2u);
  EXPECT_TRUE(damped[0].limited);
  EXPECT_EQ(damped[0].friction, 3);
  EXPECT_EQ(damped[0].motor_force, 0);
  EXPECT_FALSE(damped[0].spring);
  EXPECT_EQ(damped[1].spring.value().damping, 2);
  EXPECT_FALSE(damped[1].limited);
  const auto wheel = joints("continuous", R"(<dynamics damping="2"/>)", R"("spring": {"stiffness": 5, "damping": 1})");
  ASSERT_EQ(wheel.size(), 1u);
  EXPECT_FALSE(wheel[0].limited);
  EXPECT_EQ(wheel[0].spring.value().damping, 3);
  const auto driven = joints("continuous", R"(<dynamics friction="3"/>)", R"("motor": {"speed": 4, "max_torque": 9})");
  ASSERT_EQ(driven.size(), 2u);
  EXPECT_EQ(driven[0].motor_speed, 4);
  EXPECT_EQ(driven[0].motor_force, 9);
  EXPECT_EQ(driven[1].motor_force, 0);
  EXPECT_EQ(driven[1].friction, 3);
  const auto planar = joints("planar", R"(<axis xyz="0 0 2"/><dynamics friction="3"/>)", "");
  ASSERT_EQ(planar.size(), 1u);
  EXPECT_EQ(planar[0].kind, JOINT_PLANAR);
  EXPECT_FALSE(planar[0].limited);
  EXPECT_EQ(planar[0].axis, (Vector3{0, 0, 2}));
  EXPECT_EQ(planar[0].friction, 3);
}

// Limits that are never met change nothing, though they make two joints of one.
TEST_F(Robots, TwoJointsInsteadOfOneSwingAsOneDoes) {
  const auto swung = [&](const std::string& type) {
    return coordinate_after(scene_of(robot(link("world", "") + link("a", arm_along_x) +
                                           joint(type, "world", "a", R"(<axis xyz="0 1 0"/><dynamics damping="1"/>
                                                 <limit lower="-3" upper="3"/>)"))),
                            40);
  };
  const double one = swung("continuous"), two = swung("revolute");
  EXPECT_GT(one, 0.5);
  EXPECT_NEAR(two, one, 1e-6);
}

TEST_F(Robots, ShapesAreThoseOfTheSceneFormat) {
  const auto shape = [&](const std::string& geometry) {
    return scene_of(robot(link("a", unit_inertial + "<collision><origin xyz=\"1 0 0\"/><geometry>" + geometry +
                                        "</geometry></collision>")),
                    R"(, "material": "ice", "category": "robots", "collides_with": ["default"])",
                    R"(, "materials": [{"name": "wood"}, {"name": "ice", "friction": 0}],
                       "bodies": [{"type": "static", "shapes": [{"type": "plane"}]}])")
        .bodies.at(1)
        .shapes.at(0);
  };
  const ShapeDescription box = shape(R"(<box size="2 4 6"/>)");
  EXPECT_EQ(box.kind, SHAPE_BOX);
  EXPECT_EQ(box.half_extents, (Vector3{1, 2, 3}));
  EXPECT_EQ(box.offset, (Vector3{1, 0, 0}));
  EXPECT_EQ(box.material, 1u);
  EXPECT_EQ(box.category, 2u);
  EXPECT_EQ(box.mask, 1u);
  const ShapeDescription cylinder = shape(R"(<cylinder radius="0.5" length="3"/>)");
  EXPECT_EQ(cylinder.kind, SHAPE_CYLINDER);
  EXPECT_EQ(cylinder.radius, 0.5);
  EXPECT_EQ(cylinder.half_length, 1.5);
  EXPECT_EQ(shape(R"(<capsule radius="0.5" length="3"/>)").kind, SHAPE_CAPSULE);
  EXPECT_EQ(shape(R"(<sphere radius="0.5"/>)").radius, 0.5);
}

TEST_F(Robots, MeshesBecomeHullsFoundFromTheFileOrItsPackage) {
  std::filesystem::create_directories(folder_.file("arm/urdf"));
  std::filesystem::create_directories(folder_.file("arm/meshes"));
  std::ofstream(folder_.file("arm/meshes/wedge.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n";
  for (const char* name : {"package://arm/meshes/wedge.obj", "../meshes/wedge.obj"}) {
    const std::string mesh =
        "<collision><geometry><mesh filename=\"" + std::string(name) + "\" scale=\"2 4 -6\"/></geometry></collision>";
    const std::string file = folder_.file("arm/urdf/arm.urdf");
    std::ofstream(file) << robot(link("a", unit_inertial + mesh));
    const Scene scene = read_scene(file);
    EXPECT_EQ(scene.name, "arm");
    const ShapeDescription& shape = scene.bodies.at(0).shapes.at(0);
    EXPECT_EQ(shape.kind, SHAPE_HULL);
    EXPECT_EQ(shape.points.size(), 4u);
    EXPECT_EQ(shape.offset, (Vector3{1, 2, -3})) << "the middle of its box";
  }
}

// Meshes of robots have thousands of points; of those a hull can have 128.
TEST_F(Robots, MeshesOfManyCornersAreHulledNearly) {
  const Scene scene = parse_scene(robot(link("a", unit_inertial + R"(<collision><geometry>
      <mesh filename="scenes/meshes/blob.obj"/></geometry></collision>)")),
                                  "lump.urdf");
  const ShapeDescription& shape = scene.bodies.at(0).shapes.at(0);
  EXPECT_EQ(shape.points.size(), most_hull_vertices);
  EXPECT_NEAR(half_extents_of(shape.points)[2], 0.5 * (0.56967 + 0.597959), 1e-5) << "its size is that of the mesh";
}

TEST_F(Robots, ARobotAloneIsAScene) {
  const std::string path = folder_.file("alone.urdf");
  std::ofstream(path) << robot(link("a") + link("b") + joint("continuous", "a", "b"));
  const Scene scene = read_scene(path);
  EXPECT_EQ(scene.name, "alone");
  EXPECT_EQ(scene.bodies.size(), 2u);
  EXPECT_EQ(scene.bodies[0].name, "x/a");
  compile<float>(scene);
  EXPECT_FALSE(parse_camera(scene.text, scene.source));
}

TEST_F(Robots, JointsOfTheSceneConnectLinks) {
  const Scene scene = scene_of(robot(link("a")), "", R"(, "joints": [{"type": "ball", "bodies": ["world", "r/a"],
                                                                      "anchor": [0, 0, 1]}])");
  EXPECT_EQ(scene.joints.at(0).body_b, 0u);
}

}  // namespace
}  // namespace lockstep::robots_test
