// MJCF files that are none, or that describe what cannot be: the exact line that each kind is refused with.
#include <map>
#include <set>
#include <sstream>

#include "host/scene/compile.hpp"
#include "host/scene/mjcf_schema.hpp"
#include "host/scene/read.hpp"
#include "tests/refusal.hpp"

namespace lockstep::bad_mjcf_test {
namespace {

struct Bad {
  std::string file, line;
};

std::string refusal(const std::string& file) {
  return lockstep::refusal([&] { compile<float>(parse_scene(file, "robot.xml")); });
}

std::string file(const std::string& inside) { return "<mujoco>\n" + inside + "\n</mujoco>"; }
std::string in_world(const std::string& inside) { return file("<worldbody>" + inside + "</worldbody>"); }
std::string in_body(const std::string& inside) {
  return in_world("<body name=\"a\">" + inside + "<geom size=\"1\"/></body>");
}
std::string of_joint(const std::string& inside) { return in_body("<joint name=\"j\" " + inside + "/>"); }
std::string of_geom(const std::string& inside) {
  return in_world("<body name=\"a\"><freejoint/><geom " + inside + "/></body>");
}
std::string beside(const std::string& more) {
  return file("<worldbody><body name=\"a\"><joint name=\"j\"/><geom size=\"1\"/></body></worldbody>\n" + more);
}

TEST(BadMjcf, EachKindOfBadFileIsRefusedInOneLine) {
  const std::string inertial = "<freejoint/><inertial pos=\"0 0 0\" ";
  const Bad bad[] = {
      {"<mujoco>", "robot.xml:1: not XML: XML_ERROR_MISMATCHED_ELEMENT"},
      {"<robot/>", "robot.xml:1: <robot>: is no <mujoco>, as the first element of an MJCF file must be"},
      {file("<include file=\"x.xml\"/>"),
       "robot.xml:2: <include> file: names no file: \"x.xml\" does not exist; it is looked for from the folder of this "
       "file, and from that of the first one"},
      {file(""), "robot.xml:1: <mujoco>: has no bodies and no geoms in a <worldbody>; a robot needs some"},
      {beside("<tendon><spatial name=\"t\" stiffness=\"3\"/></tendon>"),
       "robot.xml:3: <spatial> stiffness: is of a tendon that pulls, and spatial ones are not simulated; remove it, or "
       "run with --approximate"},
      {beside("<tendon><fixed name=\"t\" frictionloss=\"3\"><joint joint=\"j\" coef=\"1\"/></fixed></tendon>"),
       "robot.xml:3: <fixed> frictionloss: is of a tendon and not simulated; remove it, or run with --approximate"},
      {beside("<tendon><fixed name=\"t\" stiffness=\"3 1\"><joint joint=\"j\" coef=\"1\"/></fixed></tendon>"),
       "robot.xml:3: <fixed> stiffness: is not linear, which is not simulated; give one number, or run with "
       "--approximate"},
      {beside("<tendon><fixed stiffness=\"3\" springlength=\"0 1\"><joint joint=\"j\" coef=\"1\"/></fixed></tendon>"),
       "robot.xml:3: <fixed> springlength: has a range in which the spring does not pull, which is not simulated; give "
       "one number, or run with --approximate"},
      {beside("<tendon><fixed range=\"2 1\"><joint joint=\"j\" coef=\"1\"/></fixed></tendon>"),
       "robot.xml:3: <fixed> range: must not begin above its end, is 2 to 1"},
      {beside("<tendon><fixed stiffness=\"3\"><joint joint=\"k\" coef=\"1\"/></fixed></tendon>"),
       "robot.xml:3: <joint> joint: unknown joint \"k\"; did you mean \"j\"?"},
      {beside("<equality><tendon tendon1=\"t\"/></equality>"),
       "robot.xml:3: <tendon> tendon1: unknown fixed tendon \"t\"; there are none"},
      {file("<compiler coordinate=\"global\"/>"),
       "robot.xml:2: <compiler> coordinate: must be local; MuJoCo 2.3 converts"},
      {file("<compiler angle=\"grad\"/>"), "robot.xml:2: <compiler> angle: must be degree or radian, is \"grad\""},
      {file("<compiler eulerseq=\"xy\"/>"),
       "robot.xml:2: <compiler> eulerseq: must be three of the letters xyzXYZ, is \"xy\""},
      {file("<option timestep=\"0\"/>"), "robot.xml:2: <option> timestep: must be > 0, is 0"},
      {file("<option density=\"1.2\"/>"),
       "robot.xml:2: <option> density: is not simulated, and changes the motion; set it to 0, or run with "
       "--approximate"},
      {in_body("<composite/>"),
       "robot.xml:2: <composite>: is not simulated, and moves bodies; remove it, or run with --approximate"},
      {in_world("<body childclass=\"x\"/>"), "robot.xml:2: <body> childclass: unknown class \"x\"; known: main"},
      {in_world("<body name=\"a\"/><body name=\"a\"/>"),
       "robot.xml:2: <body> name: names the body \"a\" again; names must differ"},
      {in_world("<body name=\"a\"><joint/></body>"),
       "robot.xml:2: <body> \"a\": has no mass; give it an <inertial>, or fix a link with one to it"},
      {in_world("<body><geom size=\"1\"/><body><freejoint/><geom size=\"1\"/></body></body>"),
       "robot.xml:2: <freejoint>: is free, and its body is part of another one; only those of the world are"},
      {in_body("<freejoint/><joint/>"),
       "robot.xml:2: <joint>: stands beside a free joint; a body that is free has no other joint"},
      {in_body("<joint name=\"j\"/><joint name=\"j\" axis=\"1 0 1\"/>"),
       "robot.xml:2: <joint> \"j\": has the name of another joint; names must differ"},
      {in_body(inertial + "mass=\"1\"/>"), "robot.xml:2: <inertial>: needs the attribute \"diaginertia\""},
      {in_body(inertial + "mass=\"1\" diaginertia=\"1 1 3\"/>"),
       "robot.xml:2: <inertial>: must keep the triangle inequality of real bodies, its principal moment 3 is more than "
       "2, the sum of the others"},
      {in_body(inertial + "mass=\"1\" fullinertia=\"1 1 1 2 0 0\"/>"),
       "robot.xml:2: <inertial>: must be positive definite, has the principal moment -1"},
      {of_joint("type=\"hing\""), "robot.xml:2: <joint> type: unknown joint \"hing\"; did you mean \"hinge\"?"},
      {of_joint("axis=\"0 0 0\""), "robot.xml:2: <joint> axis: must not be zero: it is a direction"},
      {of_joint("damping=\"-1\""), "robot.xml:2: <joint> damping: must be >= 0, is -1"},
      {of_joint("range=\"30 20\""), "robot.xml:2: <joint> range: must not begin above its end, is 30 to 20"},
      {of_joint("limited=\"true\""), "robot.xml:2: <joint>: needs the attribute \"range\""},
      {of_joint("limited=\"yes\""), "robot.xml:2: <joint> limited: must be true, false or auto, is \"yes\""},
      {of_joint("type=\"ball\" damping=\"1\""),
       "robot.xml:2: <joint> damping: belongs to a joint with one axis, and this one has none; set it to 0 here, or "
       "run "
       "with --approximate"},
      {of_joint("armature=\"-1\""), "robot.xml:2: <joint> armature: must be >= 0, is -1"},
      {of_joint("type=\"ball\" range=\"0 30\""),
       "robot.xml:2: <joint>: is a ball with limits, which are not simulated; give limited=\"false\", hinges in its "
       "place, or run with --approximate"},
      {of_geom(""), "robot.xml:2: <geom>: needs the attribute \"size\""},
      {of_geom("size=\"-1\""), "robot.xml:2: <geom> size: must be > 0, is -1"},
      {of_geom("size=\"1\" type=\"ellipsoids\""),
       "robot.xml:2: <geom> type: unknown shape \"ellipsoids\"; did you mean \"ellipsoid\"?"},
      {of_geom("type=\"box\" size=\"1 1\""), "robot.xml:2: <geom> size: must be 3 finite numbers, is \"1 1\""},
      {of_geom("type=\"capsule\" size=\"1\" fromto=\"1 1 1 1 1 1\""),
       "robot.xml:2: <geom> fromto: must be two points, they are one"},
      {of_geom("type=\"plane\" size=\"1 1 1\""),
       "robot.xml:2: <geom>: is a plane, which has no mass; its body must be fixed to the world"},
      {of_geom("type=\"mesh\" mesh=\"m\""), "robot.xml:2: <geom> mesh: unknown mesh \"m\"; there are none"},
      {of_geom("mesh=\"m\""), "robot.xml:2: <geom> mesh: unknown mesh \"m\"; there are none"},
      {of_geom("size=\"1\" fromto=\"0 0 0 1 0 0\""),
       "robot.xml:2: <geom> fromto: is of capsules, cylinders and boxes; leave it out, and give pos"},
      {of_geom("size=\"1\" quat=\"0 0 0 0\""), "robot.xml:2: <geom> quat: must not be zero"},
      {of_geom("size=\"1\" quat=\"1 0 0 0\" euler=\"0 0 0\""),
       "robot.xml:2: <geom> euler: stands beside quat; give one orientation"},
      {of_geom("size=\"1\" euler=\"0 0 1e9\""),
       "robot.xml:2: <geom> euler: must be in -1000000 .. 1000000, is 1000000000"},
      {of_geom("size=\"1\" friction=\"-1\""), "robot.xml:2: <geom> friction: must be >= 0"},
      {of_geom("size=\"1\" contype=\"1.5\""), "robot.xml:2: <geom> contype: must be an integer of 32 bits, is 1.5"},
      {file("<asset><mesh file=\"nothing.stl\"/></asset>"),
       "robot.xml:2: <mesh> file: names no file: \"nothing.stl\" does not exist; it is looked for from the folder of "
       "the robot's file and the compiler's meshdir"},
      {file("<asset><mesh name=\"m\" vertex=\"0 0 0 1 0 0 0 1 0 1 1 0\"/></asset><worldbody><body><freejoint/>"
            "<geom type=\"mesh\" mesh=\"m\"/></body></worldbody>"),
       "robot.xml:2: <mesh> vertex: its points lie in a plane; give it a thickness, or use a box"},
      {file("<default><default/></default>"), "robot.xml:2: <default>: needs the attribute \"class\""},
      {beside("<actuator><motor joint=\"k\"/></actuator>"),
       "robot.xml:3: <motor> joint: unknown joint \"k\"; did you mean \"j\"?"},
      {beside("<actuator><muscle joint=\"j\"/></actuator>"),
       "robot.xml:3: <muscle>: is not simulated, and moves bodies; remove it, or run with --approximate"},
      {beside("<actuator><general joint=\"j\" biastype=\"affine\" biasprm=\"0 1 0\"/></actuator>"),
       "robot.xml:3: <general>: pushes a joint away from where it is to be, which is not simulated; remove it, or run "
       "with --approximate"},
      {beside("<equality><joint joint1=\"j\" joint2=\"j\"/></equality>"),
       "robot.xml:3: <joint>: ties what is the same; remove it"},
      {beside("<equality><joint joint1=\"j\" joint2=\"j\" polycoef=\"0 1 2\"/></equality>"),
       "robot.xml:3: <joint> polycoef: is not linear, which is not simulated; give two numbers, or run with "
       "--approximate"},
      {beside("<equality><weld body1=\"a\" body2=\"a\"/></equality>"),
       "robot.xml:3: <weld>: names one body twice; it holds two"},
      {beside("<equality><weld site1=\"a\" site2=\"a\"/></equality>"),
       "robot.xml:3: <weld> site1: unknown site \"a\"; there are none"},
      {beside("<contact><pair geom1=\"x\" geom2=\"y\"/></contact>"),
       "robot.xml:3: <pair>: is not read; contype and conaffinity of geoms say who touches; or run with --approximate"},
      {beside("<contact><exclude body1=\"a\" body2=\"b\"/></contact>"),
       "robot.xml:3: <exclude> body2: unknown body \"b\"; did you mean \"a\"?"},
      {file("<worldbody><body name=\"a\"><freejoint/><geom size=\"1\"/></body><body name=\"b\"><freejoint/>"
            "<geom size=\"1\"/></body></worldbody><contact><exclude body1=\"a\" body2=\"b\"/></contact>"),
       "robot.xml: has bodies that are to pass through each other (<exclude>) and no joint, and the list of such pairs "
       "is one of joints; give their geoms contype and conaffinity"},
  };
  for (const auto& [text, line] : bad) EXPECT_EQ(refusal(text), line) << text;
  EXPECT_EQ(refusal(beside("")), "accepted");
}

TEST(BadMjcf, WhatIsForOtherProgramsIsPassedOver) {
  EXPECT_EQ(
      refusal(beside("<tendon><fixed "
                     "name=\"t\"/></tendon><visual/><statistic/><sensor><gyro/></sensor><keyframe/><custom/><size/>")),
      "accepted");
  EXPECT_EQ(refusal(in_body("<site/><camera/><light/><freejoint/>")), "accepted");
}

std::vector<std::string> notes(const std::string& file, RobotReading reading = {}) {
  return parse_scene(file, "robot.xml", 0, reading).notes;
}

TEST(BadMjcf, WhatIsLeftOutIsCountedAndTold) {
  const std::string robot =
      in_body("<camera/><camera/><light name=\"l\"/><geom size=\"1\" rgba=\"1 0 0 1\" solref=\"1 1\"/>");
  EXPECT_EQ(notes(robot), (std::vector<std::string>{"left out: 2 x `camera`, 1 x `light`, 1 x `geom rgba`",
                                                    "hard here: 1 x `geom solref`"}));
  EXPECT_TRUE(notes(in_body("")).empty());
  // words that MJCF does not have, too
  EXPECT_EQ(notes(of_joint("dampng=\"1\"")), std::vector<std::string>{"left out: 1 x `joint dampng`"});
  EXPECT_EQ(notes(in_body("<gom size=\"1\"/>")), std::vector<std::string>{"left out: 1 x `gom`"});
  EXPECT_EQ(notes(in_body("<geom type=\"ellipsoid\" size=\"1 2 3\"/>")),
            std::vector<std::string>{"replaced: 1 x `ellipsoid` by `a hull of 128 corners`"});
}

TEST(BadMjcf, StrictReadingRefusesWhatWouldBeLeftOut) {
  const auto refused = [](const std::string& file) {
    return lockstep::refusal([&] { notes(file, {.strict = true}); });
  };
  EXPECT_EQ(refused(in_body("<camera/>")), "robot.xml:2: <camera>: is not simulated: it would be left out (--strict)");
  EXPECT_EQ(refused(of_joint("margin=\"1\"")),
            "robot.xml:2: <joint> margin: is not simulated: constraints are hard (--strict)");
  EXPECT_EQ(refused(in_body("")), "accepted");
}

TEST(BadMjcf, AnApproximationLeavesOutWhatChangesTheMotionAndTellsIt) {
  const std::string robot = beside("<option density=\"1.2\"/><actuator><muscle joint=\"j\"/></actuator>");
  EXPECT_EQ(notes(robot, {.approximate = true}),
            std::vector<std::string>{"APPROXIMATED, the motion is another one: 1 x `option density`, 1 x `muscle`"});
}

// The table of MuJoCo's words: none twice, and what moves bodies is refused wherever it stands.
TEST(BadMjcf, EachWordHasOneRowOfTheTable) {
  std::set<std::string> known;
  for (const MjcfRow& row : mjcf_rows()) {
    std::istringstream words{std::string(row.attributes)};
    for (std::string word; words >> word;)
      EXPECT_TRUE(known.insert(std::string(row.parent) + " " + std::string(row.element) + " " + word).second)
          << row.element << " " << word;
  }
  EXPECT_GT(known.size(), 400u);
}

TEST(BadMjcf, EachAttributeThatChangesTheMotionIsRefusedUnlessItIsNeutral) {
  const std::map<std::string_view, std::string> before = {{"body", "<worldbody><body><geom size=\"1\"/>"},
                                                          {"contact", "<contact>"},
                                                          {"tendon", "<tendon>"},
                                                          {"actuator", "<actuator>"},
                                                          {"asset", "<asset>"},
                                                          {"mujoco", ""}};
  const std::map<std::string_view, std::string> after = {{"body", "</body></worldbody>"}, {"contact", "</contact>"},
                                                         {"tendon", "</tendon>"},         {"actuator", "</actuator>"},
                                                         {"asset", "</asset>"},           {"mujoco", ""}};
  u32 seen = 0;
  for (const MjcfRow& row : mjcf_rows()) {
    if (row.role != MjcfRole::MOVES || row.attributes == "*") continue;
    ASSERT_TRUE(before.contains(row.parent)) << row.parent;
    std::istringstream words{std::string(row.attributes)};
    for (std::string word; words >> word; ++seen) {
      const std::string element = std::string(row.element) + " " + word + "=\"7\"";
      const std::string line = refusal(file(before.at(row.parent) + "<" + element + "/>" + after.at(row.parent)));
      EXPECT_EQ(
          line.find("robot.xml:2: <" + std::string(row.element) + "> " + word + ": is not simulated, and changes"), 0u)
          << line;
    }
  }
  EXPECT_GT(seen, 20u);
}

}  // namespace
}  // namespace lockstep::bad_mjcf_test
