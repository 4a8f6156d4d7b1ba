// URDF files that are none, or that describe what cannot be: the exact line that each kind is refused with.
#include "tests/robots.hpp"

namespace lockstep::bad_robots_test {
namespace {

using BadRobots = Robots;

struct Bad {
  std::string robot, line;
};

TEST_F(BadRobots, EachKindOfBadFileIsRefusedInOneLine) {
  const std::string a = link("a"), ab = link("a") + link("b");
  const auto inertial = [](const std::string& inside) {
    return robot(link("a", "<inertial>" + inside + "</inertial>"));
  };
  const auto collision = [](const std::string& inside) {
    return robot(link("a", "<collision>" + inside + "</collision>"));
  };
  const auto inertia = [&](const std::string& moments) {
    return inertial("<mass value=\"1\"/><inertia " + moments + "/>");
  };
  const std::string limit = R"(<limit lower="-1" upper="1"/>)";
  const Bad bad[] = {
      {"", "robot.urdf:0: not XML: XML_ERROR_EMPTY_DOCUMENT"},
      {"<robot name=\"x\">\n<link>\n", "robot.urdf:2: not XML: XML_ERROR_PARSING"},
      {"<robot name=\"x\">\n</rob>\n", "robot.urdf:1: not XML: XML_ERROR_MISMATCHED_ELEMENT"},
      {"<sdf/>", "robot.urdf:1: <sdf>: is no <robot>, as the first element of a URDF file must be"},
      {"<robot/>", "robot.urdf:1: <robot>: has no <link>; a robot needs one"},
      {"<robot name=\"\"/>", "robot.urdf:1: <robot> name: must not be empty"},
      {"<robot name=\"a&#10;b\"/>", "robot.urdf:1: <robot> name: must be a text of one line in UTF-8, is \"a\\nb\""},
      {"<robot name=\"\xff\"/>", "robot.urdf:1: <robot> name: must be a text of one line in UTF-8, is \"\\ufffd\""},
      {"<robot name=\"x\" name=\"y\"/>", "robot.urdf:1: not XML: XML_ERROR_PARSING_ATTRIBUTE"},
      {robot(""), "robot.urdf:1: <robot>: has no <link>; a robot needs one"},
      {robot("<xacro:macro/>"), "robot.urdf:2: <xacro:macro>: is to be expanded first: xacro x.urdf.xacro > x.urdf"},
      {robot("<link/>"), "robot.urdf:2: <link>: needs the attribute \"name\""},
      {robot(a + a), "robot.urdf:3: <link> name: names the link \"a\" again; names must differ"},
      {robot(a + link("b", "") + joint("floating", "a", "b")),
       "robot.urdf:3: <link> \"b\": has no mass; give it an <inertial>, or fix a link with one to it"},
      {robot(link("a", unit_inertial + unit_inertial)), "robot.urdf:2: <inertial>: stands twice in <link>; remove one"},
      {inertial(""), "robot.urdf:2: <inertial>: needs the element <mass>"},
      {inertial("<mass value=\"1\"/>"), "robot.urdf:2: <inertial>: needs the element <inertia>"},
      {inertial("<mass value=\"-1\"/><inertia/>"), "robot.urdf:2: <mass> value: must be >= 0, is -1"},
      {inertial("<mass value=\"1kg\"/><inertia/>"), "robot.urdf:2: <mass> value: must be a finite number, is \"1kg\""},
      {inertial("<mass value=\"nan\"/><inertia/>"), "robot.urdf:2: <mass> value: must be a finite number, is \"nan\""},
      {inertial("<mass value=\"1e999\"/><inertia/>"),
       "robot.urdf:2: <mass> value: must be a finite number, is \"1e999\""},
      {inertia("ixx=\"1\" iyy=\"1\""), "robot.urdf:2: <inertia>: needs the attribute \"izz\""},
      {inertial("<origin xyz=\"1 2\"/><mass value=\"1\"/><inertia/>"),
       "robot.urdf:2: <origin> xyz: must be 3 finite numbers, is \"1 2\""},
      {inertial("<origin xyz=\"1,,2 3\"/><mass value=\"1\"/><inertia/>"),
       "robot.urdf:2: <origin> xyz: must be 3 finite numbers, is \"1,,2 3\""},
      {inertial("<origin xyz=\"1, 2, 3,\"/><mass value=\"1\"/><inertia/>"),
       "robot.urdf:2: <origin> xyz: must be 3 finite numbers, is \"1, 2, 3,\""},
      {inertial("<origin xyz=\"1 2 3 4\"/><mass value=\"1\"/><inertia/>"),
       "robot.urdf:2: <origin> xyz: must be 3 finite numbers, is \"1 2 3 4\""},
      {inertial("<origin rpy=\"0 1e9 0\"/><mass value=\"1\"/><inertia/>"),
       "robot.urdf:2: <origin> rpy: must be in -10000 .. 10000 rad, is 1000000000"},
      {collision(""), "robot.urdf:2: <collision>: needs the element <geometry>"},
      {collision("<geometry/>"),
       "robot.urdf:2: <geometry>: must hold one box, cylinder, sphere, capsule or mesh, has 0; give each a "
       "<collision>"},
      {collision("<geometry><cone/></geometry>"),
       "robot.urdf:2: <geometry>: must hold one box, cylinder, sphere, capsule or mesh, has 0; give each a "
       "<collision>"},
      {collision("<geometry><sphere radius=\"0\"/></geometry>"), "robot.urdf:2: <sphere> radius: must be > 0, is 0"},
      {collision("<geometry><cylinder radius=\"1\"/></geometry>"),
       "robot.urdf:2: <cylinder>: needs the attribute \"length\""},
      {collision("<geometry><box size=\"1 -2 3\"/></geometry>"),
       "robot.urdf:2: <box> size: must be > 0 along each axis, is -2"},
      {collision("<geometry><mesh filename=\"none.stl\"/></geometry>"),
       "robot.urdf:2: <mesh> filename: names no file: \"none.stl\" does not exist; a mesh is looked for from the "
       "folder "
       "of the robot's file"},
      {collision("<geometry><mesh filename=\"package://none/x.stl\"/></geometry>"),
       "robot.urdf:2: <mesh> filename: \"package://none/x.stl\" is in no folder above the robot's file; say where its "
       "package is by --package NAME=FOLDER or ROS_PACKAGE_PATH, or give a path from its file"},
      {collision("<geometry><mesh filename=\"http://x/x.stl\"/></geometry>"),
       "robot.urdf:2: <mesh> filename: \"http://x/x.stl\" is no file here; give a path from the robot's file"},
      {collision("<geometry><mesh filename=\"x.stl\" scale=\"1 0 1\"/></geometry>"),
       "robot.urdf:2: <mesh> scale: must not be 0: the mesh would be flat"},
      {robot(ab + "<joint name=\"j\"/>"), "robot.urdf:4: <joint>: needs the attribute \"type\""},
      {robot(ab + joint("hinge", "a", "b")),
       "robot.urdf:4: <joint> type: unknown joint \"hinge\"; known: fixed, revolute, continuous, prismatic, planar, "
       "floating, spherical"},
      {robot(ab + "<joint name=\"j\" type=\"fixed\"><child link=\"b\"/></joint>"),
       "robot.urdf:4: <joint>: needs the element <parent>"},
      {robot(a + joint("fixed", "a", "c")), "robot.urdf:3: <child> link: unknown link \"c\"; did you mean \"a\"?"},
      {robot(ab + joint("revolute", "a", "b")), "robot.urdf:4: <joint>: needs the element <limit>"},
      {robot(ab + joint("prismatic", "a", "b", R"(<limit lower="1" upper="-1"/>)")),
       "robot.urdf:4: <limit>: lower must not be above upper, they are 1 and -1"},
      {robot(ab + joint("revolute", "a", "b", limit + R"(<axis xyz="0 0 0"/>)")),
       "robot.urdf:4: <axis> xyz: must not be zero: it is a direction"},
      {robot(ab + joint("revolute", "a", "b", limit + R"(<dynamics damping="-1"/>)")),
       "robot.urdf:4: <dynamics> damping: must be >= 0, is -1"},
      {robot(ab + joint("spherical", "a", "b", R"(<dynamics damping="1"/>)")),
       "robot.urdf:4: <dynamics>: belongs to a joint with one axis, a spherical one has none; set it to 0 here"},
      {robot(ab + joint("revolute", "a", "b", limit + R"(<mimic joint="k"/>)")),
       "robot.urdf:4: <mimic> joint: unknown joint \"k\"; known: a_b"},
      {robot(ab + joint("revolute", "a", "b", limit + R"(<mimic joint="a_b"/>)")),
       "robot.urdf:4: <mimic> joint: follows itself, from one joint to the next"},
      {robot(ab + joint("fixed", "a", "b", R"(<mimic joint="a_b"/>)")),
       "robot.urdf:4: <mimic>: belongs to a joint with one axis that moves; remove it"},
      {robot(ab + joint("fixed", "a", "b") + joint("fixed", "a", "b")),
       "robot.urdf:5: <joint> name: names the joint \"a_b\" again; names must differ"},
      {robot(ab),
       "robot.urdf:3: <link> \"b\": is held by no joint, nor is the link \"a\"; a robot is one tree, join them"},
      {robot(ab + joint("fixed", "a", "b") + joint("fixed", "b", "a")),
       "robot.urdf:1: <robot>: has no link that is no child of a joint; its joints go round in a ring"},
      {robot(ab + link("c") + joint("fixed", "a", "c") + joint("fixed", "b", "c")),
       "robot.urdf:6: <joint> \"b_c\": the link \"c\" is the child of the joint \"a_c\" already; a robot is a tree"},
      {robot(ab + link("c") + joint("fixed", "b", "c") + joint("fixed", "c", "b")),
       "robot.urdf:3: <link> \"b\": is in a ring of joints; a robot is a tree"},
  };
  for (const Bad& file : bad) EXPECT_EQ(refusal(file.robot), file.line) << file.robot;
}

TEST_F(BadRobots, WhatASceneSaysWrongOfARobotIsRefused) {
  const std::string good = robot(link("a") + link("b") + joint("fixed", "a", "b") + link("c") +
                                 joint("prismatic", "a", "c", R"(<limit lower="0" upper="1"/>)"));
  EXPECT_EQ(refusal(good), "accepted");
  const auto said = [&](const std::string& joints) { return refusal(good, ", \"joints\": [" + joints + "]"); };
  const std::pair<std::string, std::string> bad[] = {
      {refusal(good, R"(, "colour": 1)"),
       "scene.json: /robots/0: unknown key \"colour\"; known: file, keyframe, name, position, orientation, fixed, "
       "material, "
       "category, collides_with, joints"},
      {refusal(good, R"(, "material": "ice")"),
       "scene.json: /robots/0/material: unknown material \"ice\"; known: default"},
      {said(R"({"name": "a_d"})"),
       "scene.json: /robots/0/joints/0/name: unknown joint that moves \"a_d\"; did you mean \"a_c\"?"},
      {said(R"({"name": "a_b"})"),
       "scene.json: /robots/0/joints/0/name: unknown joint that moves \"a_b\"; did you mean \"a_c\"?"},
      {said(R"({"name": "a_c"}, {"name": "a_c"})"),
       "scene.json: /robots/0/joints/1/name: names the joint \"a_c\" again; say all in one place"},
      {said(R"({"name": "a_c", "start_deg": 1})"),
       "scene.json: /robots/0/joints/0/start_deg: belongs to a joint that turns; give \"start\""},
      {said(R"({"name": "a_c", "motor": {"speed": 1, "max_torque": 1}})"),
       "scene.json: /robots/0/joints/0/motor: unknown key \"max_torque\"; did you mean "
       "\"max_force\"?"},
  };
  for (const auto& [found, expected] : bad) EXPECT_EQ(found, expected);
  const auto refusal_of = [](const std::string& text) {
    return lockstep::refusal([&] { parse_scene(text, "s.json"); });
  };
  EXPECT_EQ(
      refusal_of(R"({"robots": [{"file": "none.urdf"}]})"),
      "s.json: /robots/0/file: names no file: \"none.urdf\" does not exist; a robot is looked for from the folder "
      "of the scene");
  EXPECT_EQ(refusal_of(R"({"robots": [{"file": "x.obj"}]})"),
            "s.json: /robots/0/file: must be the name of a .urdf or .xml file, is \"x.obj\"");
  EXPECT_EQ(refusal_of(R"({"robots": []})"), "s.json: /robots: is empty; a scene needs a body");
  EXPECT_EQ(refusal_of(R"({})"), "s.json: needs the key \"bodies\"");
  const std::string twice = R"({"file": "scenes/robots/sweeper.urdf", "fixed": true})";
  EXPECT_EQ(refusal_of("{\"robots\": [" + twice + "," + twice + "]}"),
            "s.json: /robots: bodies 0 and 4 are both named \"sweeper/pedestal\"; names must differ");
}

}  // namespace
}  // namespace lockstep::bad_robots_test
