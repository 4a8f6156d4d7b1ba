// Joints that come to a world of the library, and go.
#include <cmath>

#include "tests/library_worlds.hpp"

namespace lockstep::world_joints_test {
namespace {

JointDescription ball_joint(const Vector3& anchor) {
  return {.name = "shoulder", .kind = JOINT_BALL, .anchor_a = anchor, .anchor_b = anchor};
}

TEST(WorldJoints, AJointThatIsAddedAtFirstIsThatOfTheScene) {
  Scene scene = empty_scene();
  scene.gravity = {0, 0, -9.81};
  scene.bodies = {box_at({0, 0, 0}), box_at({2, 0, 0})};
  World late(scene, in_double());
  scene.joints = {ball_joint({1, 0, 0.5}), ball_joint({0, 1, 0.5})};
  scene.joints[0].body_a = 0, scene.joints[0].body_b = 1;
  scene.joints[1].name = "nail";
  scene.joints[1].body_a = 0;
  World early(scene, in_double());
  const JointHandle shoulder = late.add(ball_joint({1, 0, 0.5}), late.bodies()[0], late.bodies()[1]);
  late.add(scene.joints[1], late.bodies()[0]);
  early.step(40);
  late.step(40);
  EXPECT_EQ(late.state_hash(), early.state_hash());
  EXPECT_EQ(late.joints().size(), 2u);
  EXPECT_EQ(early.joints().size(), 2u);
  EXPECT_EQ(late.find_joint("shoulder"), shoulder);
  EXPECT_EQ(late.description(*late.find_joint("nail")).body_b, NONE);
  EXPECT_FALSE(late.find_joint("hip"));
}

TEST(WorldJoints, AJointIsFoundByItsSecondBody) {
  Scene scene = empty_scene();
  scene.bodies = {box_at({0, 0, 0}), box_at({2, 0, 0})};
  scene.bodies[0].name = "arm", scene.bodies[1].name = "hand";
  World world(scene, in_double());
  const JointHandle shoulder = world.add(ball_joint({1, 0, 0.5}), world.bodies()[0], world.bodies()[1]);
  EXPECT_EQ(world.find_joint("hand"), shoulder);
  EXPECT_FALSE(world.find_joint("arm"));
  JointDescription second = ball_joint({1, 0, -0.5});
  second.name = "wrist";
  world.add(second, world.bodies()[0], world.bodies()[1]);
  EXPECT_FALSE(world.find_joint("hand")) << "two hold it";
  second.name = "hand";
  const JointHandle named = world.add(second, world.bodies()[1]);
  EXPECT_EQ(world.find_joint("hand"), named);
}

// A turning, flying box is caught by its corner: from there on it is the pendulum that begins so.
TEST(WorldJoints, AJointThatIsAddedLaterFixesTheBodyWhereItIsThen) {
  Scene scene = empty_scene(0.002);
  replace_solver(scene.settings, Solver::small_steps);
  scene.gravity = {0, 0, -9.81};
  scene.bodies = {box_at({0, 0, 0})};
  scene.bodies[0].velocity = {1, 0, 2};
  scene.bodies[0].angular_velocity = {0, 3, 1};
  World world(scene, in_double());
  const BodyHandle box = world.bodies()[0];
  world.step(100);
  const Pose then = world.pose(box);
  scene.bodies[0].position = then.position;
  scene.bodies[0].orientation = then.orientation;
  scene.bodies[0].velocity = world.velocity(box).linear;
  scene.bodies[0].angular_velocity = world.velocity(box).angular;
  const Vector3 nail = exact::add(then.position, exact::rotate(then.orientation, {0.5, 0.5, 0.5}));
  JointDescription hinge = ball_joint(nail);
  hinge.kind = JOINT_HINGE;
  hinge.axis = {0, 1, 0.2};
  world.add(hinge, box);
  hinge.body_a = 0;
  scene.joints = {hinge};
  World pendulum(scene, in_double());
  for (int i = 0; i < 300; ++i) {
    world.step();
    pendulum.step();
    const Pose a = world.pose(box), b = pendulum.pose(pendulum.bodies()[0]);
    for (unsigned k = 0; k < 3; ++k) ASSERT_NEAR(a.position[k], b.position[k], 1e-11) << i;
    for (unsigned k = 0; k < 4; ++k) ASSERT_NEAR(a.orientation[k], b.orientation[k], 1e-11) << i;
    const Vector3 corner = exact::add(a.position, exact::rotate(a.orientation, {0.5, 0.5, 0.5}));
    ASSERT_LT(exact::length(exact::subtract(corner, nail)), 1e-3) << i;
  }
}

// A body that came since the last step stands where it was put, one whose index has changed where it is; and what stand
// a description brings along does not matter.
TEST(WorldJoints, ConnectBodiesThatHaveJustCome) {
  World world(empty_scene(), in_double());
  const BodyHandle gone = world.add(box_at({0, 9, 0})), old = world.add(box_at({0, 0, 0}));
  world.set_velocity(old, {{1, 0, 0}, {0, 0, 0}});
  world.step(100);
  world.remove(gone);
  const BodyHandle young = world.add(box_at({3, 0, 0}));
  JointDescription joint = ball_joint({2, 0, 0});
  joint.reference_poses = {{5, 5, 5}, {6, 6, 6}};
  world.add(joint, old, young);
  world.step(50);
  EXPECT_NEAR(world.pose(old).position[0], 1.25, 1e-2) << "at half the speed, both";
  EXPECT_NEAR(world.pose(young).position[0], 3.25, 1e-2);
  EXPECT_NEAR(world.velocity(young).linear[0], 0.5, 1e-3);
}

TEST(WorldJoints, JointsGoAndHandlesStayGood) {
  Scene scene = empty_scene();
  World world(scene, in_double());
  const BodyHandle a = world.add(box_at({0, 0, 0})), b = world.add(box_at({2, 0, 0})), c = world.add(box_at({4, 0, 0}));
  const JointHandle first = world.add(ball_joint({1, 0, 0}), a, b), second = world.add(ball_joint({3, 0, 0}), b, c);
  world.set_velocity(c, {{1, 0, 0}, {0, 0, 0}});
  world.step(10);
  EXPECT_NEAR(world.velocity(a).linear[0], 1.0 / 3, 1e-2) << "it pulls both";
  world.remove(first);
  EXPECT_FALSE(world.contains(first));
  EXPECT_TRUE(world.contains(second));
  EXPECT_EQ(world.joints().size(), 1u);
  const double left = world.velocity(a).linear[0];
  world.set_velocity(c, {{2, 0, 0}, {0, 0, 0}});
  world.step(10);
  EXPECT_EQ(world.velocity(a).linear[0], left) << "nothing holds it";
  EXPECT_NEAR(world.velocity(b).linear[0], world.velocity(c).linear[0], 1e-2);
  world.remove(c);
  EXPECT_FALSE(world.contains(second)) << "it went with its body";
  EXPECT_NE(world.add(ball_joint({1, 0, 0}), a, b), first) << "never given twice";
  EXPECT_EQ(refusal([&] { world.remove(first); }), "joint \"shoulder\": is not in this world any more");
  world.step();
}

// A cube of 2 kg and edge 1 m on an axle through its centre, I = m a^2 / 6: a torque M that is not yet enough changes
// its angular velocity by M / I dt in a step. The world, b, turns against it.
TEST(WorldJoints, MotorsAreDrivenOtherwiseWhileAWorldRuns) {
  World world(empty_scene(0.01), in_double());
  const BodyHandle box = world.add(box_at({0, 0, 0}));
  JointDescription hinge = ball_joint({0, 0, 0});
  hinge.kind = JOINT_HINGE;
  const JointHandle axle = world.add(hinge, box);
  const auto angular_velocity = [&] { return world.velocity(box).angular[2]; };
  world.step(10);
  EXPECT_EQ(angular_velocity(), 0);
  world.set_motor(axle, -2, 1);
  world.step(50);
  EXPECT_NEAR(angular_velocity(), 1.5, 1e-12) << "1 N m / (1/3 kg m^2), half a second";
  world.step(50);
  EXPECT_NEAR(angular_velocity(), 2, 1e-12) << "there";
  world.set_motor(axle, 1, 2);
  world.step(10);
  EXPECT_NEAR(angular_velocity(), 1.4, 1e-12) << "braked by 6 rad/s^2";
  EXPECT_EQ(world.description(axle).motor_force, 2);
  const BodyHandle other = world.add(box_at({9, 0, 0}));
  world.step(10);
  EXPECT_NEAR(angular_velocity(), 0.8, 1e-12) << "also of a world made anew";
  world.set_motor(axle, 0, 0);
  world.remove(other);
  world.set_motor(axle, 0, 0);
  world.step(10);
  EXPECT_NEAR(angular_velocity(), 0.8, 1e-12) << "let go";
  EXPECT_EQ(refusal([&] { world.set_motor(axle, std::nan(""), 1); }), "joint \"shoulder\": must be finite");
  EXPECT_EQ(refusal([&] { world.set_motor(axle, 0, -1); }),
            "joint \"shoulder\": must have no negative motor force, frequency or damping");
  World coarse(empty_scene(), {.device = "reference", .precision = "float"});
  const JointHandle weak = coarse.add(hinge, coarse.add(box_at({0, 0, 0})));
  EXPECT_EQ(refusal([&] { coarse.set_motor(weak, 0, 1e300); }),
            "joint \"shoulder\": the force of a motor, or of friction must fit float, is 1e+300");
  const JointHandle socket = world.add(ball_joint({0, 0, 0}), box);
  EXPECT_EQ(refusal([&] { world.set_motor(socket, 0, 1); }),
            "joint \"shoulder\": has nothing to limit, to drive or to push by a spring");
  world.remove(axle);
  EXPECT_EQ(refusal([&] { world.set_motor(axle, 0, 0); }), "joint \"shoulder\": is not in this world any more");
}

// A box of 2 kg that has fallen for a while comes onto a spring, and to rest k x = m g below where it was then.
TEST(WorldJoints, ASpringThatComesLaterCarries) {
  Scene scene = empty_scene(0.005);
  scene.gravity = {0, 0, -10};
  World world(scene, in_double());
  const BodyHandle box = world.add(box_at({0, 0, 0}));
  world.step(20);
  const double height = world.pose(box).position[2];
  JointDescription slider = ball_joint({0, 0, 0});
  slider.kind = JOINT_SLIDER;
  slider.axis = {0, 0, -1};
  slider.spring = {.stiffness = 100, .damping = 30};
  world.add(slider, box);
  world.step(1000);
  EXPECT_NEAR(world.pose(box).position[2], height - 0.2, 1e-9);
  EXPECT_NEAR(world.velocity(box).linear[2], 0, 1e-9);
}

// Friction stays what it is while others are driven, and needs the row that a motor would have.
TEST(WorldJoints, FrictionIsNoMotorThatCanBeSet) {
  World world(empty_scene(0.01), in_double());
  const BodyHandle wheel = world.add(box_at({0, 0, 0})), other = world.add(box_at({9, 0, 0}));
  JointDescription hinge = ball_joint({0, 0, 0});
  hinge.kind = JOINT_HINGE;
  hinge.friction = 0.1;
  const JointHandle axle = world.add(hinge, wheel);
  hinge.friction = 0;
  hinge.anchor_a = hinge.anchor_b = {9, 0, 0};
  const JointHandle driven = world.add(hinge, other);
  world.set_velocity(wheel, {{0, 0, 0}, {0, 0, 1}});
  world.step(10);
  world.set_motor(driven, 1, 1);
  world.step(10);
  EXPECT_NEAR(world.velocity(wheel).angular[2], 1 - 0.2 * 0.1 * 3, 1e-12) << "0.1 N m on 1/3 kg m^2";
  EXPECT_NEAR(std::abs(world.state(axle).drive), 0.1, 1e-12);
  EXPECT_EQ(refusal([&] { world.set_motor(axle, 1, 1); }),
            "joint \"shoulder\": must not have both a motor and friction; take this off the motor's force");
}

// A nut is run up its thread by a torque, turns over turns; a new screw has kernels built that know of screws.
TEST(WorldJoints, AScrewAddedLaterCountsItsRevolutions) {
  World world(empty_scene(0.001), in_double());
  const BodyHandle nut = world.add(box_at({0, 0, 0}));  // 2 kg, 1/3 kg m^2
  world.step(2);
  JointDescription screw = ball_joint({0, 0, 0});
  screw.kind = JOINT_SCREW;
  screw.pitch = 0.1;
  const JointHandle thread = world.add(screw, nut);
  world.set_motor(thread, 1000, 5);
  world.step(2000);
  const double pi = 3.141592653589793, lead = 0.1 / (2 * pi), moment = 1.0 / 3 + 2 * lead * lead;
  const JointState state = world.state(thread);  // of the world against the nut
  EXPECT_NEAR(state.speed, 2 * 5 / moment, 1e-9);
  EXPECT_NEAR(state.coordinate, 2 * 5 / moment, 5e-3 + 2e-3 * 5 / moment);  // M t^2 / 2 I
  EXPECT_NEAR(world.pose(nut).position[2], -lead * state.coordinate, 1e-9);
  EXPECT_GT(state.coordinate, 4 * 2 * pi);
  EXPECT_LT(state.separation, 1e-9);
}

// ---- what joints tell

Scene heavy_scene(double dt = 0.01) {
  Scene scene = empty_scene(dt);
  replace_solver(scene.settings, Solver::small_steps);
  scene.gravity = {0, 0, -9.81};
  return scene;
}

// A beam of 6 kg and 2 m, nailed to the world at one end and held level there: m g down, m g l / 2 about the nail.
TEST(WorldJoints, AFixedJointTellsWhatItCarries) {
  World world(heavy_scene(), in_double());
  BodyDescription beam;
  beam.position = {1, 0, 5};
  beam.orientation = exact::rotation({0, 0, 1}, std::sin(0.3), std::cos(0.3));  // its own axes are not the world's
  beam.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {0.1, 0.1, 0.1}});
  make_solid_of_mass(beam, 6);
  const BodyHandle body = world.add(beam);
  JointDescription nail = ball_joint({0, 0, 5});
  nail.kind = JOINT_FIXED;
  const JointHandle joint = world.add(nail, body);
  EXPECT_EQ(exact::length(world.state(joint).force), 0);
  world.step(200);
  const JointState state = world.state(joint);  // on its second side, the world
  const double weight = 6 * 9.81;
  EXPECT_NEAR(state.force[2], -weight, 1e-4 * weight);
  EXPECT_NEAR(std::hypot(state.force[0], state.force[1]), 0, 1e-4 * weight);
  EXPECT_NEAR(state.torque[1], weight, 1e-3 * weight);  // r x F = (1, 0, 0) x (0, 0, -m g)
  EXPECT_LT(state.separation, 1e-3);
  EXPECT_LT(state.angle, 1e-3);
  EXPECT_EQ(state.coordinate, 0);
  EXPECT_EQ(state.speed, 0);
  EXPECT_EQ(state.drive, 0);
}

// A wheel of a given moment about a fixed axis under a constant torque: w = M t / I, angle = M t^2 / 2 I.
TEST(WorldJoints, AHingeTellsItsAngleItsRateAndItsMotor) {
  World world(empty_scene(1e-3), in_double());
  const BodyHandle wheel = world.add(box_at({0, 0, 0}, 6));  // I = 1
  JointDescription hinge = ball_joint({0, 0, 0});
  hinge.kind = JOINT_HINGE;
  hinge.axis = {0, 1, 0};
  const JointHandle axle = world.add(hinge, wheel);
  world.set_motor(axle, 1000, 0.5);  // never gets there: all that it has
  world.step(1000);
  const JointState state = world.state(axle);
  EXPECT_NEAR(std::abs(state.speed), 0.5, 1e-9);
  EXPECT_NEAR(std::abs(state.coordinate), 0.25, 1e-3);
  EXPECT_NEAR(std::abs(state.drive), 0.5, 1e-9);
  EXPECT_GT(state.speed * state.coordinate, 0);
  EXPECT_GT(state.speed * state.drive, 0);
  world.set_motor(axle, 0, 0);
  world.step();
  EXPECT_NEAR(world.state(axle).drive, 0, 1e-12);
}

// What hangs on a rod, and what a slider moves up evenly: both carry the weight.
TEST(WorldJoints, ARodAndASliderTellWhatTheyPullWith) {
  World world(heavy_scene(), in_double());
  const BodyHandle hanging = world.add(box_at({0, 0, 3}, 2)), lifted = world.add(box_at({9, 0, 3}, 2));
  JointDescription rod;
  rod.kind = JOINT_DISTANCE;
  rod.anchor_a = {0, 0, 3};
  rod.anchor_b = {0, 0, 7};
  rod.limited = true;
  rod.low = rod.high = 4;
  const JointHandle up = world.add(rod, hanging);
  JointDescription rail = ball_joint({9, 0, 3});
  rail.kind = JOINT_SLIDER;
  rail.axis = {0, 0, 1};
  const JointHandle lift = world.add(rail, lifted);
  world.set_motor(lift, -0.5, 1000);  // of the world against the box: the box goes up
  world.step(200);
  const JointState pulled = world.state(up), raised = world.state(lift);
  EXPECT_NEAR(pulled.coordinate, 4, 1e-3);
  EXPECT_NEAR(pulled.speed, 0, 1e-6);
  EXPECT_NEAR(pulled.drive, -2 * 9.81, 1e-3);  // on the world, away from the box would be positive
  EXPECT_NEAR(raised.coordinate, -1, 1e-2);
  EXPECT_NEAR(raised.speed, -0.5, 1e-6);
  EXPECT_NEAR(raised.drive, -2 * 9.81, 1e-3);
  EXPECT_NEAR(world.velocity(lifted).linear[2], 0.5, 1e-6);
}

// ---- bodies that are put elsewhere

// A double pendulum begins a second time, all of it turned about the vertical: its joints hold it as they did, and it
// swings as it did, turned.
TEST(WorldJoints, ABodyTeleportedToItsFirstPoseSwingsAsItDid) {
  const Quaternion rotation = exact::rotation({0, 0, 1}, std::sin(0.4), std::cos(0.4));
  for (const bool joined_late : {false, true}) {
    Scene scene = heavy_scene(0.002);
    scene.bodies = {box_at({1, 0, 0}), box_at({2, 0, 0.5})};
    JointDescription shoulder = ball_joint({0, 0, 0}), elbow = ball_joint({1.5, 0.5, 0.25});
    shoulder.body_a = elbow.body_b = 0;
    elbow.body_a = 1;
    if (!joined_late) scene.joints = {shoulder, elbow};
    World world(scene, in_double());
    const BodyHandle upper = world.bodies()[0], lower = world.bodies()[1];
    if (joined_late) {
      world.add(shoulder, upper);
      world.add(elbow, lower, upper);
    }
    world.step(150);
    const Pose first = world.pose(lower);
    world.step(250);
    for (const BodyHandle body : {upper, lower})
      world.teleport(body, {exact::rotate(rotation, world.description(body).position), rotation});
    for (const JointHandle joint : world.joints()) EXPECT_LT(world.state(joint).separation, 1e-12);
    EXPECT_EQ(exact::length(world.velocity(lower).linear), 0);
    world.step(150);
    const Vector3 expected = exact::rotate(rotation, first.position);
    EXPECT_LT(exact::length(exact::subtract(world.pose(lower).position, expected)), 1e-5);
  }
}

TEST(WorldJoints, InvalidJointsAreRefused) {
  World world(ground_scene(), in_double());
  const BodyHandle box = world.add(box_at({0, 0, 1})), other = world.add(box_at({3, 0, 1}));
  const BodyHandle floor = *world.find("floor");
  const auto refused = [&](const std::function<void(JointDescription&)>& change) {
    JointDescription joint = ball_joint({1.5, 0, 1});
    joint.kind = JOINT_HINGE;
    change(joint);
    return refusal([&] { world.add(joint, box, other); });
  };
  EXPECT_EQ(refused([](JointDescription&) {}), "accepted");
  EXPECT_EQ(refused([](JointDescription& joint) {
              joint.axis = {0, 0, 0};
            }),
            "joint \"shoulder\": must have an axis that is not zero");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.anchor_b[1] = std::nan(""); }),
            "joint \"shoulder\": must be finite");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.limited = true, joint.low = 1, joint.high = 0; }),
            "joint \"shoulder\": must not have a low limit above the high one");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.limited = true, joint.low = -40; }), "accepted");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.start = std::nan(""); }), "joint \"shoulder\": must be finite");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.kind = JOINT_BALL, joint.motor_force = 1; }),
            "joint \"shoulder\": has nothing to limit, to drive or to push by a spring");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.kind = JOINT_BALL, joint.friction = 1; }),
            "joint \"shoulder\": has nothing to limit, to drive or to push by a spring");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.friction = -1; }),
            "joint \"shoulder\": must have no negative friction");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.kind = JOINT_SCREW; }),
            "joint \"shoulder\": must have a pitch that is not 0");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.kind = JOINT_SCREW, joint.pitch = std::nan(""); }),
            "joint \"shoulder\": must be finite");
  EXPECT_EQ(refused([](JointDescription& joint) {
              joint.kind = JOINT_UNIVERSAL, joint.second_axis = {1, 0, 1};
            }),
            "joint \"shoulder\": must have a second axis that is perpendicular to the first");
  EXPECT_EQ(refused([](JointDescription& joint) {
              joint.kind = JOINT_SCREW, joint.pitch = 1, joint.limited = true, joint.low = -40;
            }),
            "accepted");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.damping = -1; }),
            "joint \"shoulder\": must have no negative motor force, frequency or damping");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.spring = {.stiffness = -1}; }),
            "joint \"shoulder\": must have a spring with a stiffness or a damping above 0, and neither below");
  EXPECT_EQ(refused([](JointDescription& joint) { joint.armature = -1; }),
            "joint \"shoulder\": must have no negative armature");
  EXPECT_EQ(refusal([&] {
              world.add(ball_joint({0, 0, 0}), box, box);
            }),
            "joint \"shoulder\": names one body twice; a joint holds two");
  EXPECT_EQ(refusal([&] {
              world.add(ball_joint({0, 0, 0}), floor);
            }),
            "joint \"shoulder\": one of its two bodies must be dynamic");
  world.step(3);
}

}  // namespace
}  // namespace lockstep::world_joints_test
