// A motor that presses a joint on its limit rests there, by every oracle that solves cones beside drives and bounds.
#include "include/lockstep/world.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::motor_at_limit_test {
namespace {

class MotorAtLimit : public testing::TestWithParam<const char*> {
 protected:
  // A body about z; a motor of 0.5 N m drives it from 0 to a limit at 1 rad, `sign` says which way.
  static Scene pressed(double sign) {
    BodyDescription body = bare_body({0, 0, 0});
    Scene scene = joint_scene({body}, {joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0})}, 0.01);
    scene.name = scene.source = "pressed";
    scene.gravity = {0, 0, 0};
    replace_solver(scene.settings, *find_solver(GetParam()));
    scene.joints[0].limited = true;
    scene.joints[0].low = -1;
    scene.joints[0].high = 1;
    scene.joints[0].motor_speed = sign * 2;
    scene.joints[0].motor_force = 0.5;
    return scene;
  }
};

INSTANTIATE_TEST_SUITE_P(Oracles, MotorAtLimit,
                         testing::Values("nsgs", "newton", "admm", "apgd", "auto", "reduced_nsgs", "reduced_auto"));

TEST_P(MotorAtLimit, RestsThere) {
  for (const double sign : {1.0, -1.0}) {
    World world(pressed(sign), {.device = "reference"});
    const JointHandle joint = world.joints()[0];
    world.step(30);
    EXPECT_NEAR(world.state(joint).speed, sign * 0.3 * 5, 1e-9) << "0.5 N m on 0.1 kg m^2";
    world.step(70);
    EXPECT_NEAR(world.state(joint).coordinate, sign, 1e-6);
    EXPECT_NEAR(world.state(joint).speed, 0, 1e-6);
    EXPECT_NEAR(world.state(joint).drive, 0, 1e-4) << "the limit pushes back with what the motor has";
  }
}

// And leaves it as soon as it turns round.
TEST_P(MotorAtLimit, IsLeftAgain) {
  World world(pressed(1), {.device = "reference"});
  const JointHandle joint = world.joints()[0];
  world.step(100);
  world.set_motor(joint, -2, 0.5);
  world.step(20);
  EXPECT_NEAR(world.state(joint).speed, -0.2 * 5, 1e-6);
  world.step(200);
  EXPECT_NEAR(world.state(joint).coordinate, -1, 1e-6);
}

}  // namespace
}  // namespace lockstep::test::motor_at_limit_test
