// Actuators of MJCF that are driven while a world runs, against closed forms.
#include <cmath>

#include "tests/command_line.hpp"
#include "tests/library_worlds.hpp"
#include "tests/mjcf_scene.hpp"

namespace lockstep::actuators_test {
namespace {

// A wheel of 2 kg m^2 about its axis, and a slide of 3 kg; nothing pulls.
Scene driven(const std::string& actuators, const std::string& joint = "", double dt = 0.001) {
  return mjcf_scene::mjcf(
      "<compiler angle=\"radian\"/><option gravity=\"0 0 0\" timestep=\"" + std::to_string(dt) +
      "\"/><worldbody><body name=\"wheel\"><joint name=\"axle\" axis=\"0 0 1\" " + joint +
      "/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"2 2 2\"/></body><body name=\"cart\"><joint name=\"rail\" "
      "type=\"slide\" axis=\"1 0 0\"/><inertial pos=\"0 0 0\" mass=\"3\" diaginertia=\"1 1 1\"/></body></worldbody>"
      "<actuator>" +
      actuators + "</actuator>");
}

JointState state(World& world, const std::string& name) { return world.state(*world.find_joint("r/" + name)); }

// alpha = gear u / I, kept to the range of the control, then to that of the force.
TEST(Actuators, AMotorGivesItsControl) {
  World world(driven("<motor name=\"rotate\" joint=\"axle\" gear=\"4\" ctrlrange=\"-3 3\"/><motor name=\"push\" "
                     "joint=\"rail\" forcerange=\"-6 6\"/>"),
              in_double());
  world.step(100);
  EXPECT_EQ(state(world, "axle").speed, 0);
  double wheel = 0, cart = 0;
  for (const auto& [torque, push] :
       {std::pair(1.0, 3.0), std::pair(-2.0, 9.0), std::pair(5.0, -12.0), std::pair(0.0, 0.0)}) {
    world.set_control(world.actuator("r/rotate"), torque);
    world.set_control(1, push);
    world.step(100);
    wheel += 0.1 * 4 * std::min(torque, 3.0) / 2;
    cart += 0.1 * std::clamp(push, -6.0, 6.0) / 3;
    EXPECT_NEAR(state(world, "axle").speed, wheel, 1e-9) << torque;
    EXPECT_NEAR(state(world, "rail").speed, cart, 1e-9) << push;
  }
}

TEST(Actuators, AServoGoesWhereItsControlSays) {
  for (const char* precision : {"float", "double"}) {
    World world(driven("<position joint=\"axle\" kp=\"200\" kv=\"40\" gear=\"2\"/><position joint=\"rail\" kp=\"300\" "
                       "kv=\"60\" forcerange=\"-5 5\" ctrlrange=\"-1 1\"/>",
                       "ref=\"0.5\""),
                {.device = "reference", .precision = precision});
    EXPECT_EQ(world.actuators()[0].name, "r/actuator_0");
    for (const auto& [axle, rail] : {std::pair(3.0, 0.5), std::pair(-7.0, -0.25), std::pair(0.0, 4.0)}) {
      world.set_control(0, axle);
      world.set_control(1, rail);
      world.step(5000);
      // in float what is slower than a rounding of its position in a sub-step of 0.1 ms stands still
      const double bound = std::string(precision) == "float" ? 1e-4 : 2e-6;
      EXPECT_NEAR(state(world, "axle").coordinate, axle / 2 - 0.5, bound) << axle;
      EXPECT_NEAR(state(world, "rail").coordinate, std::min(rail, 1.0), bound) << rail;
    }
  }
}

// kv (u - w) against the damping c of the joint: w = kv u / (kv + c).
TEST(Actuators, AVelocityServoReachesItsSpeed) {
  World world(driven("<velocity joint=\"axle\" kv=\"30\"/>", "damping=\"10\""), in_double());
  world.set_control(0, 8);
  world.step(3000);
  EXPECT_NEAR(state(world, "axle").speed, 6, 1e-9);
}

// Two servos and a spring of one joint rest where k1 (u1 - q) + k2 (u2 - q) + k3 (s - q) = 0.
TEST(Actuators, ServosOfOneJointPullTogether) {
  World world(driven("<position joint=\"axle\" kp=\"100\" kv=\"20\"/><position joint=\"axle\" kp=\"50\"/>",
                     "stiffness=\"50\" springref=\"0.4\""),
              in_double());
  for (const auto& [a, b] : {std::pair(0.0, 0.0), std::pair(1.0, 0.0), std::pair(1.0, -2.0)}) {
    world.set_control(0, a);
    world.set_control(1, b);
    world.step(8000);
    EXPECT_NEAR(state(world, "axle").coordinate, (100 * a + 50 * b + 50 * 0.4) / 200, 1e-8);
  }
}

// A constant bias is a force that is always there.
TEST(Actuators, ABiasPushes) {
  World world(driven("<general joint=\"rail\" biastype=\"affine\" biasprm=\"6 0 0\"/>"), in_double());
  world.step(100);
  EXPECT_NEAR(state(world, "rail").speed, 0.2, 1e-12);
  world.set_control(0, -6);
  world.step(100);
  EXPECT_NEAR(state(world, "rail").speed, 0.2, 1e-12);
}

constexpr char several[] =
    "<motor joint=\"axle\"/><position joint=\"rail\" kp=\"300\" kv=\"60\" forcerange=\"-5 5\"/><position "
    "joint=\"axle\" kp=\"30\" kv=\"6\"/>";

// What is done to actuators is in a recording, and a snapshot goes back to it; the same bits on a device.
using RecordedActuators = CommandLine;

TEST_F(RecordedActuators, AreReplayedAndRestored) {
  std::vector<std::uint64_t> hashes;
  for (const char* device : {"reference", "auto"}) {
    World world(driven(several, "frictionloss=\"0.1\""), {.device = device});
    const std::string path = file(std::string(device) + ".h5").string();
    world.record(path);
    const auto live = [&](double control) {
      for (u32 i = 0; i < 3; ++i) world.set_control(i, control);
      world.set_rest(world.joints()[world.actuators()[1].joint], 0.1 * control);
      world.step(20);
      return world.state_hash();
    };
    live(0.5);
    const Snapshot snapshot = world.save();
    const std::uint64_t there = live(2);
    live(-1);
    world.restore(snapshot);
    EXPECT_EQ(world.actuators()[1].control, 0.5);
    EXPECT_EQ(live(2), there);
    hashes.push_back(there);
    world.end_recording();
    for (const char* replayed_on : {"reference", "auto"})
      EXPECT_EQ(run("verify " + path + " --device " + replayed_on).status, 0) << replayed_on;
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Actuators, WakeWhatSleeps) {
  Scene scene = driven(several);
  scene.settings.sleeping.emplace();
  World world(scene, in_double());
  world.step(3000);
  const BodyHandle wheel = *world.find("r/wheel");
  ASSERT_TRUE(world.is_asleep(wheel));
  world.set_control(2, 1);
  world.step(1);
  EXPECT_FALSE(world.is_asleep(wheel));
}

TEST(Actuators, RefuseInOneLine) {
  World world(driven("<motor name=\"m\" joint=\"axle\"/><position name=\"p\" joint=\"rail\" kp=\"1\" "
                     "timeconst=\"1\"/><general name=\"g\" joint=\"rail\" gaintype=\"affine\" gainprm=\"1 1 0\"/>"),
              {.device = "reference", .precision = "float"});
  const std::uint64_t before = world.state_hash();
  EXPECT_EQ(refusal([&] { world.actuator("r/n"); }), "world: unknown actuator \"r/n\"; did you mean \"r/m\"?");
  EXPECT_EQ(refusal([&] { world.set_control(3, 0); }), "world: has no actuator 3; it has 3");
  EXPECT_EQ(refusal([&] { world.set_control(1, 1); }),
            "actuator \"r/p\": has a state that follows its control, which is not simulated");
  EXPECT_EQ(refusal([&] { world.set_control(2, 1); }),
            "actuator \"r/g\": has a gain that follows its joint, so that its control stays as it is");
  EXPECT_EQ(refusal([&] { world.set_control(0, 1e60); }), "actuator \"r/m\": must be finite and fit float, is 1e+60");
  EXPECT_EQ(refusal([&] { world.set_rest(*world.find_joint("r/axle"), 1); }),
            "joint \"r/axle\": has no spring; change() gives it one");
  world.set_control(1, 0);  // as it is
  EXPECT_EQ(world.state_hash(), before);
  world.remove(*world.find_joint("r/axle"));
  EXPECT_EQ(refusal([&] { world.set_control(0, 1); }), "actuator \"r/m\": has lost its joint, which was removed");
}

}  // namespace
}  // namespace lockstep::actuators_test
