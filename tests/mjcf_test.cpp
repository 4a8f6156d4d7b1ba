// Robots from MJCF files: what becomes of bodies, geoms, joints, actuators and constraints.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>

#include "host/record/identity.hpp"
#include "host/report/joints.hpp"
#include "host/report/measures.hpp"
#include "host/scene/mass_properties.hpp"
#include "host/scene/read.hpp"
#include "host/scene/surface.hpp"
#include "tests/mjcf_scene.hpp"
#include "tests/recording_scene.hpp"
#include "tests/robots.hpp"

namespace lockstep::mjcf_test {
namespace {

using mjcf_scene::body;
using mjcf_scene::mjcf;
using mjcf_scene::world;

u32 joint_number(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.joints, "r/" + name, &JointDescription::name);
  if (found == scene.joints.end()) throw std::runtime_error("no joint " + name);
  return static_cast<u32>(found - scene.joints.begin());
}

JointMeasures joint_after(const Scene& scene, u32 steps, const std::string& name) {
  const InitialState<double> state = compile<double>(scene);
  Simulation<double> simulation = simulation_of(state);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  return measure_joint(simulation.backend().download(measured_buffers(state.features)), simulation.params(),
                       joint_number(scene, name));
}

using Mjcf = Robots;

const std::string unit_ball = R"(<geom type="sphere" size="0.1" mass="1"/>)";

// The same rods as in robots_test.cpp: MJCF and URDF make the same constants, bit for bit.
TEST_F(Mjcf, ADoublePendulumIsThatOfUrdf) {
  const std::string rod_urdf = R"(<inertial><origin xyz="0 0 -0.25"/><mass value="2"/>
      <inertia ixx="0.0625" iyy="0.0625" izz="0.001953125"/></inertial>
    <collision><origin xyz="0 0 -0.25"/><geometry><box size="0.0625 0.0625 0.5"/></geometry></collision>)";
  const Scene urdf = scene_of(robot(link("world", "") + link("upper", rod_urdf) + link("lower", rod_urdf) +
                                    joint("continuous", "world", "upper",
                                          R"(<origin xyz="0 0 2"/><axis xyz="0 1 0"/><dynamics damping="0.125"/>)") +
                                    joint("revolute", "upper", "lower", R"(<origin xyz="0 0 -0.5"/><axis xyz="0 1 0"/>
                                          <limit lower="-2" upper="1.5" effort="1" velocity="1"/>)")),
                              "", R"(, "settings": {"dt": 0.002})");
  const std::string rod = R"(<inertial pos="0 0 -0.25" mass="2" diaginertia="0.0625 0.0625 0.001953125"/>
      <geom type="box" size="0.03125 0.03125 0.25" pos="0 0 -0.25" friction="0.5"/>)";
  Scene same =
      world(R"(<body name="upper" pos="0 0 2"><joint axis="0 1 0" damping="0.125"/>)" + rod +
            R"(<body name="lower" pos="0 0 -0.5"><joint axis="0 1 0" range="-2 1.5"/>)" + rod + "</body></body>");
  EXPECT_EQ(same.settings.dt, 0.002);
  EXPECT_EQ(same.settings.steps, 2500u);
  ASSERT_EQ(same.bodies.size(), 2u);
  ASSERT_TRUE(same.joints[0].collide) << "what hangs from the world may touch what stands there";
  same.joints[0].collide = false;
  same.settings = urdf.settings;
  EXPECT_EQ(identity_of(compile<float>(urdf)), identity_of(compile<float>(same)));
  EXPECT_EQ(identity_of(compile<double>(urdf)), identity_of(compile<double>(same)));
}

TEST_F(Mjcf, MassesFollowFromGeoms) {
  const Scene scene = world(R"(
    <body name="ball"><freejoint/><geom size="0.5" density="3"/></body>
    <body name="box" pos="5 0 0"><freejoint/><geom type="box" size="0.5 1 1.5" mass="6"/></body>
    <body name="pair" pos="9 0 0"><freejoint/><geom size="0.1" mass="1" pos="-1 0 0"/><geom size="0.1" mass="3" pos="1 0 0"/>
      <geom size="5" contype="0" conaffinity="0" mass="0"/></body>
    <body name="said" pos="0 9 0"><freejoint/><inertial pos="0 0 1" mass="7" fullinertia="0.03 0.04 0.05 0.002 -0.004 0.006"/>
      <geom size="0.5"/></body>)");
  EXPECT_NEAR(body(scene, "ball").mass, 3 * 4 / 3.0 * exact::pi * 0.125, 1e-14);
  const Vector3 box = body(scene, "box").inertia;  // m / 12 (b^2 + c^2)
  EXPECT_NEAR(box[0], 0.5 * (4 + 9), 1e-14);
  EXPECT_NEAR(box[1], 0.5 * (1 + 9), 1e-14);
  EXPECT_NEAR(box[2], 0.5 * (1 + 4), 1e-14);
  EXPECT_EQ(body(scene, "pair").mass, 4);
  EXPECT_NEAR(body(scene, "pair").position[0], 9.5, 1e-15);
  EXPECT_EQ(body(scene, "pair").shapes.size(), 2u) << "what touches nothing is no shape";
  EXPECT_EQ(body(scene, "said").mass, 7);
  EXPECT_EQ(body(scene, "said").position, (Vector3{0, 9, 1}));
  const Vector3 moments = body(scene, "said").inertia;
  EXPECT_NEAR(moments[0] + moments[1] + moments[2], 0.12, 1e-15);

  const std::string two = R"(<body name="a"><freejoint/><inertial pos="0 0 0" mass="7" diaginertia="1 1 1"/>
    <geom type="box" size="0.5 0.5 0.5" mass="2"/></body>)";
  EXPECT_EQ(body(world(two, R"(<compiler inertiafromgeom="true"/>)"), "a").mass, 2);
  EXPECT_EQ(body(world(two, R"(<compiler inertiafromgeom="false"/>)"), "a").mass, 7);
  const Scene total = world(two, R"(<compiler settotalmass="14"/>)");
  EXPECT_EQ(body(total, "a").mass, 14);
  EXPECT_EQ(body(total, "a").inertia, (Vector3{2, 2, 2}));
}

// Of files and of geoms alike; the principal moments of "said" are 0.021, 0.019 and 0.001.
TEST_F(Mjcf, BoundsAreOfMassesAndPrincipalMoments) {
  const Scene scene = world(R"(<body name="ball"><freejoint/><geom size="0.01"/></body>
    <body name="said"><freejoint/><inertial pos="0 0 0" mass="1" fullinertia="0.02 0.02 0.003 0.001 0 0"/></body>
    <body name="large"><freejoint/><geom size="0.5"/></body>)",
                            R"(<compiler boundmass="0.5" boundinertia="0.01"/>)");
  EXPECT_EQ(body(scene, "ball").mass, 0.5);
  EXPECT_EQ(body(scene, "ball").inertia, (Vector3{0.01, 0.01, 0.01}));
  Vector3 moments = body(scene, "said").inertia;
  std::ranges::sort(moments);
  for (unsigned i = 0; i < 3; ++i) EXPECT_NEAR(moments[i], (Vector3{0.01, 0.019, 0.021})[i], 1e-17) << i;
  EXPECT_EQ(body(scene, "large").mass, exact::sphere_mass(1000, 0.5)) << "what is above them stays as it is";
}

TEST_F(Mjcf, OrientationsHaveFiveNotations) {
  // 30 degrees about z, and a capsule whose z axis is then compared
  const double s = std::sin(exact::pi / 12), c = std::cos(exact::pi / 12);
  const auto orientation_of = [](const std::string& how, const std::string& compiler = "") {
    return body(mjcf("<compiler " + compiler + "/><worldbody><body name=\"a\" " + how + ">" +
                     R"(<freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 2 2.5"/></body></worldbody>)"),
                "a")
        .orientation;
  };
  const std::pair<std::string, std::string> alternatives[] = {
      {"quat=\"1.9318516525781366 0 0 0.5176380902050415\"", ""},
      {"axisangle=\"0 0 2 30\"", ""},
      {"axisangle=\"0 0 2 0.5235987755982988\"", "angle=\"radian\""},
      {"xyaxes=\"0.8660254037844387 0.5 0 0 1 0\"", ""},
      {"euler=\"0 0 30\"", ""},
      {"euler=\"30 0 0\"", "eulerseq=\"zxy\""}};
  for (const auto& [how, compiler] : alternatives) {
    const Quaternion q = orientation_of(how, compiler);
    const double sign = q[3] < 0 ? -1 : 1;
    EXPECT_NEAR(sign * q[2], s, 1e-15) << how;
    EXPECT_NEAR(sign * q[3], c, 1e-15) << how;
  }
  // turns about x, then about the new y and z; or about the fixed ones: x y z of the values that MuJoCo 3 has
  const Quaternion along = orientation_of("euler=\"10 20 30\""),
                   fixed = orientation_of("euler=\"10 20 30\"", "eulerseq=\"XYZ\"");
  const double h[3] = {exact::pi / 36, exact::pi / 18, exact::pi / 12};
  const auto rotation = [&](unsigned axis) {
    Quaternion q = {0, 0, 0, std::cos(h[axis])};
    q[axis] = std::sin(h[axis]);
    return q;
  };
  const Quaternion xyz = exact::multiply(exact::multiply(rotation(0), rotation(1)), rotation(2));
  const Quaternion zyx = exact::multiply(exact::multiply(rotation(2), rotation(1)), rotation(0));
  for (unsigned i = 0; i < 4; ++i) {
    EXPECT_NEAR(along[i], xyz[i], 1e-15) << i;
    EXPECT_NEAR(fixed[i], zyx[i], 1e-15) << i;
  }
  const Quaternion z = orientation_of("zaxis=\"0 3 0\"");
  const Vector3 up = exact::rotate(z, {0, 0, 1});
  EXPECT_NEAR(up[1], 1, 1e-15);
}

TEST_F(Mjcf, DefaultsAreInherited) {
  const std::string defaults = R"(<default><geom size="0.25" density="10"/>
    <default class="heavy"><geom density="20"/><default class="large"><geom size="0.5"/></default></default></default>)";
  const Scene scene = world(R"(
    <body name="plain"><freejoint/><geom/></body>
    <body name="heavy" childclass="heavy"><freejoint/><geom/></body>
    <body name="below" childclass="heavy"><freejoint/><geom class="large"/></body>
    <body name="own" childclass="large"><freejoint/><geom density="1" class="main"/></body>)",
                            defaults);
  const auto mass = [](double density, double radius) { return exact::sphere_mass(density, radius); };
  EXPECT_EQ(body(scene, "plain").mass, mass(10, 0.25));
  EXPECT_EQ(body(scene, "heavy").mass, mass(20, 0.25));
  EXPECT_EQ(body(scene, "below").mass, mass(20, 0.5));
  EXPECT_EQ(body(scene, "own").mass, mass(1, 0.25));
}

TEST_F(Mjcf, JointsRotateAboutTheirOwnAnchor) {
  // a ball 1 m from the joint, which is not where the body's frame is; range in degrees, counted from ref
  const Scene scene = mjcf(R"(<worldbody><body name="a" pos="3 0 0">
      <joint name="j" pos="-1 0 0" axis="0 1 0" range="30 75" ref="45"/>)" +
                           unit_ball + "</body></worldbody>");
  const JointDescription& joint = scene.joints.at(0);
  EXPECT_EQ(joint.anchor_a, (Vector3{2, 0, 0}));
  EXPECT_NEAR(joint.low, -exact::pi / 12, 1e-15);
  EXPECT_NEAR(joint.high, exact::pi / 6, 1e-15);
  EXPECT_NEAR(joint_after(scene, 1000, "j").coordinate, exact::pi / 6, 2e-5) << "it falls until the limit holds it";
  const Scene slide =
      world(R"(<body name="a"><joint name="j" type="slide" axis="0 0 2" range="-0.5 3"/>)" + unit_ball + "</body>");
  EXPECT_NEAR(joint_after(slide, 1000, "j").coordinate, -0.5, 1e-5);
}

// A ball 1 m out on an arm that has swung through falls back; a spring of three revolutions holds it there against
// that.
TEST_F(Mjcf, AnglesCountRevolutions) {
  const Scene limited = mjcf(R"(<worldbody><body name="a"><joint name="j" axis="0 0 1" range="-400 700"/>)" +
                             unit_ball + "</body></worldbody>");
  EXPECT_NEAR(limited.joints.at(0).low, -400 * exact::pi / 180, 1e-14);
  EXPECT_NEAR(limited.joints.at(0).high, 700 * exact::pi / 180, 1e-14);
  const Scene sprung = mjcf(R"(<worldbody><body name="a"><joint name="j" axis="0 0 1" stiffness="100" damping="20"
      springref="1080"/>)" + unit_ball +
                            "</body></worldbody>");
  EXPECT_NEAR(joint_after(sprung, 4000, "j").coordinate, 6 * exact::pi, 1e-6);
}

TEST_F(Mjcf, SpringsOfJointsRestWhereTheyAreTold) {
  // m g = k (rest - z): counted from ref, rest is 0.5 - 0.2
  const Scene scene = world(R"(<body name="a"><joint name="j" type="slide" stiffness="100" springref="0.5" ref="0.2"
      damping="30"/>)" + unit_ball +
                            "</body>");
  EXPECT_NEAR(joint_after(scene, 4000, "j").coordinate, 0.3 - 9.81 / 100, 1e-12);
}

TEST_F(Mjcf, SeveralJointsOfABodyAreOneWhereOneDoes) {
  const Scene planar = world(R"(<body name="a"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
      <joint name="turn" axis="0 1 0" damping="1"/>)" +
                             unit_ball + "</body>");
  ASSERT_EQ(planar.joints.size(), 1u);
  EXPECT_EQ(planar.joints[0].kind, JOINT_PLANAR);
  EXPECT_EQ(planar.joints[0].axis, (Vector3{0, 1, 0}));
  ASSERT_TRUE(planar.joints[0].spring);
  const Scene universal = world(R"(<body name="a"><joint axis="1 0 0"/><joint axis="0 1 0"/>)" + unit_ball + "</body>");
  ASSERT_EQ(universal.joints.size(), 1u);
  EXPECT_EQ(universal.joints[0].kind, JOINT_UNIVERSAL);
  EXPECT_EQ(universal.joints[0].second_axis, (Vector3{0, 1, 0}));
  const Scene named =
      world(R"(<body name="a"><joint axis="1 0 0"/><joint name="b" axis="0 1 0"/>)" + unit_ball + "</body>",
            R"(<actuator><velocity joint="b"/></actuator>)");
  EXPECT_EQ(named.joints.size(), 2u) << "an actuator drives the second";
  // joints without names are counted as they stand in the file, also those that became part of another
  const Scene counted =
      world(R"(<body name="a"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
      <joint axis="0 1 0"/>)" +
            unit_ball + R"(</body><body name="b"><joint axis="1 0 0"/><joint axis="1 1 0"/>)" + unit_ball + "</body>");
  ASSERT_EQ(counted.joints.size(), 3u);
  EXPECT_EQ(counted.joints[0].name, "r/joint_2");
  EXPECT_EQ(counted.joints[2].name, "r/joint_4");
}

TEST_F(Mjcf, OtherwiseLinksComeBetweenThem) {
  const Scene scene = world(R"(<body name="root"><freejoint/>)" + unit_ball + R"(
      <body name="a" pos="0 0 -0.5"><joint name="x" axis="1 0 0" range="-1 1"/><joint name="y" axis="0 1 0" range="-1 1"/>
        <joint name="z" axis="0 0 1" damping="1"/><geom type="box" size="0.1 0.2 0.3" mass="2" pos="0 0 -0.3"/></body></body>)");
  ASSERT_EQ(scene.bodies.size(), 4u);
  double mass = 0;
  for (const BodyDescription& of : scene.bodies) mass += of.mass;
  EXPECT_NEAR(mass, 3, 1e-15) << "no mass is added";
  EXPECT_NEAR(body(scene, "a").mass, 1.8, 1e-15);
  EXPECT_TRUE(body(scene, "a.x").shapes.empty());
  EXPECT_EQ(body(scene, "a.y").position, body(scene, "a").position);
  EXPECT_NEAR(body(scene, "a.y").inertia[0], 0.05 * body(scene, "a").inertia[0] / 0.9, 1e-15);
  ASSERT_EQ(scene.joints.size(), 3u);
  EXPECT_EQ(scene.joints[2].kind, JOINT_HINGE);
  ASSERT_EQ(scene.passing.size(), 1u) << "a body passes through its parent";
  EXPECT_EQ(scene.bodies[scene.passing[0][0]].name, "r/root");
  EXPECT_EQ(scene.bodies[scene.passing[0][1]].name, "r/a");
}

// The hinges of a gimbal, one after the other: the ends of the last one's axis stand where x, then y have turned it.
TEST_F(Mjcf, JointsOfABodyRotateOneAfterTheOther) {
  const auto joint_xml = [](const std::string& name, const std::string& axis, const std::string& rest) {
    return "<joint name=\"" + name + "\" axis=\"" + axis + "\" stiffness=\"500\" damping=\"20\" springref=\"" + rest +
           "\"/>";
  };
  const Scene scene =
      world("<body name=\"a\">" + joint_xml("x", "1 0 0", "0.5") + joint_xml("y", "0 1 0", "-0.4") +
                joint_xml("z", "0 0 1", "0.3") + R"(<geom type="box" size="0.1 0.2 0.3" mass="2"/></body>)",
            R"(<option gravity="0 0 0"/>)");
  const InitialState<double> state = compile<double>(scene);
  Simulation<double> simulation = simulation_of(state);
  for (u32 i = 0; i < 3000; ++i) simulation.step();
  const Vec4<double> q = simulation.backend().download(std::vector<Buffer>{Buffer::orientations}).orientations[2];
  const auto rotation = [](double angle, const Vector3& axis) {
    return exact::rotation(axis, exact::sine(angle / 2), exact::cosine(angle / 2));
  };
  const Quaternion expected =
      exact::multiply(exact::multiply(rotation(0.5, {1, 0, 0}), rotation(-0.4, {0, 1, 0})), rotation(0.3, {0, 0, 1}));
  const Quaternion found =
      exact::multiply({q.x, q.y, q.z, q.w}, [&] {  // the frame of the body is turned to its principal axes
        const Quaternion& o = body(scene, "a").orientation;
        return Quaternion{-o[0], -o[1], -o[2], o[3]};
      }());
  for (unsigned i = 0; i < 4; ++i) EXPECT_NEAR(found[i], expected[i], 1e-6) << i;
}

// Whether two geoms touch: (a.contype & b.conaffinity) || (b.contype & a.conaffinity).
TEST_F(Mjcf, FiltersAreThoseOfTheFile) {
  const std::pair<u32, u32> filters[] = {{1, 1}, {2, 1}, {1, 2}, {0, 1}, {4, 4}, {6, 0}, {3, 5}};
  std::string bodies;
  for (const auto& [contype, conaffinity] : filters)
    bodies += "<body><freejoint/><geom size=\"1\" contype=\"" + std::to_string(contype) + "\" conaffinity=\"" +
              std::to_string(conaffinity) + "\"/></body>";
  const Scene alone = world(bodies);
  std::ofstream(folder_.file("robot.xml")) << "<mujoco><worldbody>" << bodies << "</worldbody></mujoco>";
  const Scene among = parse_scene(
      R"({"bodies": [{"mass": 1, "shapes": [{"type": "sphere", "radius": 1, "category": "own", "collides_with": ["own"]}]},
                     {"mass": 1, "shapes": [{"type": "sphere", "radius": 1}]}],
          "robots": [{"file": "robot.xml", "name": "r"}]})",
      folder_.file("scene.json"));
  for (const Scene* scene : {&alone, &among}) {
    const std::size_t first = scene->bodies.size() - std::size(filters);
    const auto touch = [&](std::size_t a, std::size_t b) {
      const ShapeDescription &x = scene->bodies[a].shapes[0], &y = scene->bodies[b].shapes[0];
      return (x.category & y.mask) != 0 && (y.category & x.mask) != 0;
    };
    for (std::size_t i = 0; i < std::size(filters); ++i) {
      for (std::size_t j = 0; j < std::size(filters); ++j) {
        const auto &a = filters[i], &b = filters[j];
        const bool expected = (a.first & b.second) != 0 || (b.first & a.second) != 0;
        EXPECT_EQ(touch(first + i, first + j), expected) << i << " " << j;
      }
      if (first == 0) continue;
      EXPECT_FALSE(touch(0, first + i)) << i;
      const bool expected = ((filters[i].first | filters[i].second) & 1) != 0;
      EXPECT_EQ(touch(1, first + i), expected) << i << ": what the scene calls nothing is as (1, 1)";
    }
  }
}

TEST_F(Mjcf, TheLargerFrictionCountsUnlessOneHasPriority) {
  const Scene scene = world(R"(<geom type="plane" size="1 1 1" friction="0.2 0.1 0.1"/>
    <body name="a"><freejoint/><geom size="1" friction="0.7"/></body>
    <body name="b"><freejoint/><geom size="1" friction="0.1" priority="1"/></body>
    <body name="c"><freejoint/><geom size="1" friction="0.9" condim="1"/></body>)");
  const auto friction = [&](const std::string& a, const std::string& b) {
    const u32 x = body(scene, a).shapes[0].material, y = body(scene, b).shapes[0].material;
    for (const MaterialPairRule& rule : scene.material_pairs)
      if (std::minmax(x, y) == std::minmax(rule.material_a, rule.material_b)) return rule.friction;
    return x == y ? scene.materials[x].friction : -1;
  };
  EXPECT_EQ(friction("world", "a"), 0.7);
  EXPECT_EQ(friction("a", "b"), 0.1);
  EXPECT_EQ(friction("world", "b"), 0.1);
  EXPECT_EQ(friction("a", "c"), 0.9);
  EXPECT_EQ(friction("c", "c"), 0) << "without friction on both sides";
}

TEST_F(Mjcf, CondimSelectsTorsionalAndRollingFriction) {
  const Scene scene = world(R"(<geom type="plane" size="1 1 1" friction="0.2 0.1 0.01"/>
    <body name="a"><freejoint/><geom size="1" friction="0.7 0.02 0.3" condim="4"/></body>
    <body name="b"><freejoint/><geom size="1" condim="6"/></body>)");
  const auto met = [&](const std::string& a, const std::string& b) {
    const u32 x = body(scene, a).shapes[0].material, y = body(scene, b).shapes[0].material;
    for (const MaterialPairRule& rule : scene.material_pairs)
      if (std::minmax(x, y) == std::minmax(rule.material_a, rule.material_b)) return rule.further;
    return scene.materials[x].further;
  };
  EXPECT_EQ(met("world", "world").torsional_friction, std::nullopt);
  EXPECT_EQ(met("world", "a").torsional_friction, 0.1);
  EXPECT_EQ(met("world", "a").rolling_friction, std::nullopt);
  EXPECT_EQ(met("a", "b").torsional_friction, 0.02);
  EXPECT_EQ(met("a", "b").rolling_friction, 0.3);
  EXPECT_EQ(met("b", "b").rolling_friction, 0.0001);
}

TEST_F(Mjcf, ActuatorsKeepTheirTarget) {
  // k_p gear^2 angle = m g l cos(angle), about y: an arm along x falls by positive angles
  const std::string arm =
      R"(<body name="a"><joint name="j" axis="0 1 0" damping="5"/><geom size="0.1" mass="1" pos="0.5 0 0"/></body>)";
  const Scene position = world(arm, R"(<actuator><position joint="j" kp="10" gear="2"/></actuator>)");
  const double angle = joint_after(position, 3000, "j").coordinate;
  EXPECT_NEAR(40 * angle, 9.81 * 0.5 * std::cos(angle), 1e-11);
  const Scene general = world(arm, R"(<actuator><general joint="j" biastype="affine" biasprm="0 -40"/></actuator>)");
  EXPECT_NEAR(joint_after(general, 3000, "j").coordinate, angle, 1e-11);
  // a velocity actuator is a damper: the speed at which it carries the weight
  const Scene velocity = world(R"(<body name="a"><joint name="j" type="slide"/>)" + unit_ball + "</body>",
                               R"(<actuator><velocity joint="j" kv="20"/><motor joint="j"/></actuator>)");
  EXPECT_NEAR(joint_after(velocity, 1000, "j").speed, -9.81 / 20, 1e-12);
  // a spring of the scene takes the place of the actuator, not of the joint's own damping
  std::ofstream(folder_.file("robot.xml")) << "<mujoco><worldbody>" << arm << "</worldbody>"
                                           << R"(<actuator><position joint="j" kp="10"/></actuator></mujoco>)";
  const Scene told = parse_scene(
      R"({"robots": [{"file": "robot.xml", "joints": [{"name": "j", "spring": {"stiffness": 70, "rest": 0.5}}]}]})",
      folder_.file("scene.json"));
  ASSERT_TRUE(told.joints.at(0).spring);
  EXPECT_EQ(told.joints[0].spring->stiffness, 70);
  EXPECT_EQ(told.joints[0].spring->rest, 0.5);
  EXPECT_EQ(told.joints[0].spring->damping, 5);
}

TEST_F(Mjcf, ConstraintsCloseRings) {
  const std::string arms = R"(<body name="a"><joint axis="0 1 0"/><geom size="0.1" pos="1 0 0" mass="1"/></body>
    <body name="b" pos="2 0 0"><joint name="j" axis="0 1 0"/><geom size="0.1" pos="-1 0 0" mass="1"/></body>)";
  const auto scene_with = [&](const std::string& equality) {
    return world(arms, "<equality>" + equality + "</equality><contact><exclude body1=\"a\" body2=\"b\"/></contact>");
  };
  const Scene connect = scene_with(R"(<connect body1="a" body2="b" anchor="1 0 0"/>)");
  ASSERT_EQ(connect.joints.size(), 3u);
  EXPECT_EQ(connect.joints[2].kind, JOINT_BALL);
  EXPECT_EQ(connect.joints[2].anchor_a, (Vector3{1, 0, 0}));
  ASSERT_EQ(connect.passing.size(), 1u);
  EXPECT_NEAR(joint_after(connect, 500, "j").coordinate, 0, 0.01) << "two arms that hold each other cannot fall";
  for (const std::string pose : {"", R"( relpose="0 1 0 0 0 0 0")"})  // MuJoCo's own default
    EXPECT_EQ(scene_with("<weld body1=\"a\" body2=\"b\"" + pose + "/>").joints[2].kind, JOINT_FIXED);
  EXPECT_EQ(scene_with(R"(<weld body1="a"/>)").joints[2].body_b, NONE) << "to the world";
  EXPECT_EQ(scene_with(R"(<weld body1="a" body2="b" active="false"/>)").joints.size(), 2u);
  const Scene locked = scene_with(R"(<joint joint1="j" polycoef="0.25"/>)");
  EXPECT_NEAR(joint_after(locked, 1000, "j").coordinate, 0.25, 2e-5);
}

// A door on a hinge to the world meets the wall of the world; in URDF it would not.
TEST_F(Mjcf, WhatHangsFromTheWorldMayTouchIt) {
  const Scene scene = world(R"(<geom type="plane" size="1 1 1" pos="0 0 -0.5"/>
    <body name="a"><joint name="j" axis="0 1 0"/><geom type="sphere" size="0.1" pos="1 0 0" mass="1"/></body>)");
  ASSERT_EQ(scene.bodies.size(), 2u);
  EXPECT_NEAR(joint_after(scene, 2000, "j").coordinate, std::asin(0.4), 2e-4) << "its ball lies on the ground";
}

TEST_F(Mjcf, BodiesWithoutJointsAreMergedIntoTheirParents) {
  const Scene scene = world(R"(<body name="post" pos="0 0 1"><geom type="cylinder" size="0.1 1"/>
      <body name="arm" pos="0 0 1"><joint axis="0 1 0"/>)" +
                            unit_ball + R"(
        <body name="hand" pos="1 0 0"><geom type="sphere" size="0.1" mass="3"/></body></body></body>)");
  ASSERT_EQ(scene.bodies.size(), 2u);
  EXPECT_EQ(body(scene, "world").kind, BODY_STATIC);
  EXPECT_EQ(body(scene, "world").shapes.at(0).offset, (Vector3{0, 0, 1}));
  EXPECT_EQ(body(scene, "arm").mass, 4);
  EXPECT_EQ(body(scene, "arm").position, (Vector3{0.75, 0, 2}));
}

TEST_F(Mjcf, EndsOfAGeomSayWhereItIs) {
  const Scene scene = world(R"(<body name="a"><freejoint/><geom type="capsule" size="0.1" fromto="1 0 0 1 4 0"/></body>
    <body name="b"><freejoint/><geom type="box" size="0.1 0.2" fromto="0 0 0 0 0 4"/></body>)");  // square, as in
                                                                                                  // MuJoCo
  const ShapeDescription& capsule = body(scene, "a").shapes.at(0);
  EXPECT_EQ(capsule.half_length, 2);
  const Vector3 along = exact::rotate(exact::multiply(body(scene, "a").orientation, capsule.rotation), {0, 0, 1});
  EXPECT_NEAR(std::abs(along[1]), 1, 1e-15);
  EXPECT_EQ(body(scene, "a").position, (Vector3{1, 2, 0}));
  EXPECT_EQ(body(scene, "b").shapes.at(0).half_extents, (Vector3{0.1, 0.1, 2}));
}

TEST_F(Mjcf, MeshesAndHeightFields) {
  // a tetrahedron at the origin: a sixth of the unit cube, scaled by 2 along x; its centre at a quarter
  std::ofstream(folder_.file("t.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  std::ofstream(folder_.file("robot.xml")) << R"(<mujoco><asset><mesh file="t.obj" scale="2 1 1"/>
      <mesh name="p" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
      <hfield name="h" nrow="2" ncol="3" size="2 1 0.5 0.1" elevation="0 1 2 3 4 5"/></asset>
    <worldbody><geom type="hfield" hfield="h" pos="0 0 7"/>
      <body name="t"><freejoint/><geom mesh="t" type="mesh" density="6"/></body>
      <body name="p"><freejoint/><geom mesh="p" type="mesh" density="6"/></body></worldbody></mujoco>)";
  const Scene scene = read_scene(folder_.file("robot.xml"));
  const auto named = [&](const std::string& name) {
    return *std::ranges::find(scene.bodies, "robot/" + name, &BodyDescription::name);
  };
  EXPECT_NEAR(named("t").mass, 2, 1e-14);
  EXPECT_NEAR(named("t").position[0], 0.5, 1e-14);
  EXPECT_NEAR(named("p").mass, 1, 1e-14);
  const BodyDescription ground = named("world");
  ASSERT_EQ(simulated_shapes(ground), 4u) << "triangles";
  // rows of the file come down along y: the corner at -x, -y is the fourth number, 3 of 0 .. 5, times 0.5 m
  std::map<std::pair<double, double>, double> heights;
  for (const Vector3& p : ground.shapes[0].surface->mesh.vertices) heights[{p[0], p[1]}] = p[2];
  EXPECT_DOUBLE_EQ((heights[{-2, -1}]), 0.3);
  EXPECT_DOUBLE_EQ((heights[{2, 1}]), 0.2);
  EXPECT_DOUBLE_EQ((heights[{2, -1}]), 0.5);
  EXPECT_DOUBLE_EQ((heights[{-2, 1}]), 0.0);
}

TEST_F(Mjcf, ARobotBringsItsContactsIntoAScene) {
  std::ofstream(folder_.file("robot.xml")) << "<mujoco model=\"m\"><worldbody><body name=\"a\"><freejoint/>"
                                           << R"(<geom size="1" friction="0.25"/></body></worldbody></mujoco>)";
  const std::string ground = R"({"materials": [{"name": "ice", "friction": 0}],
    "bodies": [{"type": "static", "shapes": [{"type": "plane"}]}], "robots": [{"file": "robot.xml")";
  const Scene own = parse_scene(ground + "}]}", folder_.file("scene.json"));
  EXPECT_EQ(own.materials.at(own.bodies.at(1).shapes[0].material).friction, 0.25);
  EXPECT_EQ(own.bodies[1].name, "m/a");
  const Scene told =
      parse_scene(ground + R"(, "material": "ice", "position": [0, 0, 3]}]})", folder_.file("scene.json"));
  EXPECT_EQ(told.bodies.at(1).shapes[0].material, 0u);
  EXPECT_EQ(told.bodies[1].position, (Vector3{0, 0, 3}));
}

TEST_F(Mjcf, TheStriderRestsOnItsLegs) {
  const Scene scene = read_scene(LOCKSTEP_SOURCE_DIR "/scenes/robots/strider.xml");
  double mass = 0;
  for (const BodyDescription& of : scene.bodies) mass += of.mass;
  EXPECT_NEAR(mass, 15.753563455201682, 1e-12) << "as MuJoCo 4.0 has it";
  const InitialState<float> state = compile<float>(scene);
  Simulation<float> simulation = simulation_of(state);
  const u32 trunk =
      static_cast<u32>(std::ranges::find(scene.bodies, "strider/trunk", &BodyDescription::name) - scene.bodies.begin());
  const auto height = [&] {
    return simulation.backend().download(std::vector<Buffer>{Buffer::positions}).positions[trunk].z;
  };
  for (u32 i = 0; i < 600; ++i) simulation.step();
  const float after_three_seconds = height();
  EXPECT_GT(after_three_seconds, 0.5f);
  for (u32 i = 0; i < 200; ++i) simulation.step();
  EXPECT_NEAR(height(), after_three_seconds, 1e-5);
}

}  // namespace
}  // namespace lockstep::mjcf_test
