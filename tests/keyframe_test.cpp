// Keyframes of MJCF: where joints start, and what servos want.
#include <cmath>

#include "host/scene/exact_math.hpp"
#include "tests/library_worlds.hpp"
#include "tests/mjcf_scene.hpp"

namespace lockstep::keyframe_test {
namespace {

using mjcf_scene::body;

constexpr char dressed[] = "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>";

Scene at_key(const std::string& bodies, const std::string& key, const std::string& more = "",
             const std::string& name = "home") {
  return parse_scene("<mujoco model=\"r\"><compiler angle=\"radian\"/>" + more + "<worldbody>" + bodies +
                         "</worldbody><keyframe><key name=\"rest\"/><key name=\"home\" " + key +
                         "/></keyframe></mujoco>",
                     "robot.xml", 0, {.keyframe = name});
}

void expect_near(const Vector3& a, const Vector3& b, double bound = 1e-15) {
  for (unsigned i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], bound) << i;
}

std::string arm() {
  return std::string("<body name=\"upper\"><joint name=\"shoulder\" axis=\"0 0 1\" ref=\"0.5\"/>") + dressed +
         "<body name=\"lower\" pos=\"2 0 0\"><joint name=\"elbow\" type=\"slide\" axis=\"0 3 0\"/>" + dressed +
         "</body></body>";
}

// The shoulder rotates by a quarter, which is 0.5 less than its coordinate in the file; the slide goes along what was
// y.
TEST(Keyframe, StartsJointsWhereItSays) {
  const double quarter = 0.5 * exact::pi;
  const Scene scene = at_key(arm(), "qpos=\"" + std::to_string(0.5 + quarter) + " 0.25\"");
  expect_near(body(scene, "upper").position, {0, 0, 0});
  expect_near(body(scene, "lower").position, {-0.25, 2, 0}, 2e-6);
  World world(scene, in_double());
  world.warm_up();
  for (const JointHandle joint : world.joints()) {
    const bool is_hinge = world.description(joint).kind == JOINT_HINGE;
    EXPECT_NEAR(world.state(joint).coordinate, is_hinge ? quarter : 0.25, 1e-6);
    EXPECT_NEAR(world.state(joint).separation, 0, 1e-12);
  }
}

TEST(Keyframe, WithoutOneBodiesAreAsInTheFile) {
  for (const char* name : {"", "rest"})
    expect_near(body(at_key(arm(), "qpos=\"1 2\"", "", name), "lower").position, {2, 0, 0});
}

TEST(Keyframe, PutsWhatIsFreeOrOnABallOrMoved) {
  const Scene scene =
      at_key(std::string("<body name=\"trunk\" pos=\"5 5 5\" euler=\"0.3 0 0\"><freejoint/>") + dressed +
                 "<body name=\"leg\" pos=\"0 0 -1\"><joint type=\"ball\" pos=\"0 0 1\"/>" + dressed +
                 "</body></body><body name=\"guide\" mocap=\"true\" pos=\"1 0 0\"><geom size=\"0.1\"/></body>",
             "qpos=\"1 2 3 2 0 0 0  1 1 0 0\" mpos=\"0 0 7\"");  // the ball by a quarter about x
  expect_near(body(scene, "trunk").position, {1, 2, 3});
  expect_near(body(scene, "leg").position, {1, 3, 3});
  expect_near(body(scene, "guide").position, {0, 0, 7});
}

// Two slides and a hinge become a planar joint, two hinges a universal one.
TEST(Keyframe, StartsJointsThatBecomeOne) {
  const Scene planar =
      at_key(std::string("<body name=\"b\"><joint type=\"slide\" axis=\"1 0 0\"/><joint type=\"slide\" "
                         "axis=\"0 0 1\"/><joint axis=\"0 1 0\" pos=\"1 0 0\"/>") +
                 dressed + "</body>",
             "qpos=\"3 4 1.5707963267948966\"");
  ASSERT_EQ(planar.joints.size(), 1u);
  EXPECT_EQ(planar.joints[0].kind, JOINT_PLANAR);
  expect_near(body(planar, "b").position, {4, 0, 5});
  const Scene universal = at_key(std::string("<body name=\"b\"><joint axis=\"0 0 1\" pos=\"-1 0 0\"/><joint "
                                             "axis=\"0 1 0\" pos=\"-1 0 0\"/>") +
                                     dressed + "</body>",
                                 "qpos=\"1.5707963267948966 0.5\"");
  ASSERT_EQ(universal.joints.size(), 1u);
  EXPECT_EQ(universal.joints[0].kind, JOINT_UNIVERSAL);
  expect_near(body(universal, "b").position, {-1, std::cos(0.5), -std::sin(0.5)});
  for (const Scene& scene : {planar, universal}) {
    World world(scene, in_double());
    world.step(0);
    EXPECT_NEAR(world.state(world.joints()[0]).separation, 0, 1e-12);
    EXPECT_NEAR(world.state(world.joints()[0]).angle, 0, 1e-7);
    EXPECT_NEAR(world.state(world.joints()[0]).coordinate, exact::pi / 2, 1e-7);
  }
}

// What closes a ring is closed where the joints are at 0, and open where a keyframe starts them otherwise.
TEST(Keyframe, LeavesRingsOpenByWhatItMoves) {
  const std::string ring = "<equality><connect body1=\"upper\" body2=\"lower\" anchor=\"1 0 0\"/></equality>";
  for (const auto& [key, open] : {std::pair("qpos=\"0.5 0\"", 0.0), std::pair("qpos=\"1.5 0.125\"", 0.125)}) {
    World world(at_key(arm(), key, ring), in_double());
    world.step(0);
    EXPECT_NEAR(world.state(world.joints().back()).separation, open, 1e-12) << key;
  }
}

// A servo wants its control of the keyframe, which its range bounds.
TEST(Keyframe, GivesServosTheirControls) {
  const std::string servos =
      "<actuator><adhesion body=\"upper\"/><position joint=\"shoulder\" kp=\"100\" kv=\"20\"/><position "
      "joint=\"elbow\" "
      "kp=\"100\" kv=\"20\" ctrlrange=\"-1 1\"/></actuator>";
  Scene scene = at_key(arm(), "qpos=\"0.5 0\" ctrl=\"0 0.75 9\"", servos + "<option gravity=\"0 0 0\"/>");
  World world(scene, in_double());
  world.step(5000);
  for (const JointHandle joint : world.joints()) {
    const bool is_hinge = world.description(joint).kind == JOINT_HINGE;
    EXPECT_NEAR(world.state(joint).coordinate, is_hinge ? 0.25 : 1, 1e-6);
  }
}

TEST(Keyframe, RefusesInOneLine) {
  const auto said = [&](const std::string& key, const std::string& name = "home") {
    return refusal([&] { at_key(arm(), key, "<actuator><motor joint=\"elbow\"/></actuator>", name); });
  };
  EXPECT_EQ(said("", "hom"), "robot.xml: unknown keyframe \"hom\"; did you mean \"home\"?");
  EXPECT_EQ(said("qpos=\"1\""), "robot.xml:1: <key> qpos: has 1 numbers, and the model wants more");
  EXPECT_EQ(said("qpos=\"1 2 3\""), "robot.xml:1: <key> qpos: has 3 numbers, and the model wants 2");
  EXPECT_EQ(said("ctrl=\"0 0\""), "robot.xml:1: <key> ctrl: has 2 numbers, and the model wants 1");
  EXPECT_EQ(said("qvel=\"0 1\""),
            "robot.xml:1: <key> qvel: is not 0, and keyframes give positions and controls alone; set it to 0, or run "
            "with --approximate");
  EXPECT_EQ(refusal([] {
              parse_scene("<mujoco><worldbody><geom size=\"1\"/></worldbody></mujoco>", "robot.xml", 0,
                          {.keyframe = "home"});
            }),
            "robot.xml: has no keyframes; leave the name of one out");
  EXPECT_EQ(refusal([] { parse_scene("<robot/>", "robot.urdf", 0, {.keyframe = "home"}); }),
            "robot.urdf: has no keyframes, which are of MJCF files; leave the name of one out");
  EXPECT_EQ(refusal([] { parse_scene("{\"bodies\": []}", "scene.json", 0, {.keyframe = "home"}); }),
            "scene.json: has no keyframes, which are of MJCF files; a robot in a scene has its own: \"keyframe\"");
}

}  // namespace
}  // namespace lockstep::keyframe_test
