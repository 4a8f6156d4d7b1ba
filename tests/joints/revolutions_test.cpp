// Angles of joints count their revolutions: motors, limits and springs beyond half of one, and what is told of it.
#include <cmath>
#include <numbers>

#include "host/record/replay.hpp"
#include "host/scene/joint_kinds.hpp"
#include "tests/joints/joint_scene.hpp"
#include "tests/library_worlds.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::test::revolutions_test {
namespace {

constexpr double pi = std::numbers::pi, inertia = 0.1;

struct Method {
  const char *name, *precision;
  bool direct = false;
};

std::ostream& operator<<(std::ostream& out, const Method& method) {
  return out << method.name << (method.direct ? ", direct, " : ", ") << method.precision;
}

class Revolutions : public testing::TestWithParam<Method> {
 protected:
  // A wheel about z, or with the angle of another joint there; nothing pulls at it.
  static Scene wheel(double dt = 1.0 / 240, JointKind kind = JOINT_HINGE) {
    const Method& method = GetParam();
    Scene scene = joint_scene({bare_body({0, 0, 0})}, {joint_of(kind, NONE, 0, {0, 0, 0})}, dt);
    scene.name = scene.source = "wheel";
    scene.gravity = {0, 0, 0};
    replace_solver(scene.settings, *find_solver(method.name));
    if (method.direct) scene.settings.joint_solver = JointSolver::direct;
    return scene;
  }

  static World world_of(const Scene& scene) {
    return World(scene, {.device = "reference", .precision = GetParam().precision});
  }
  static double angle_in(World& world) { return world.state(world.joints()[0]).coordinate; }
  static double angle_after(const Scene& scene, double time) {
    World world = world_of(scene);
    world.step(static_cast<u32>(std::lround(time / scene.settings.dt)));
    return angle_in(world);
  }
  static double rounding() { return std::string(GetParam().precision) == "float" ? 2e-4 : 1e-9; }
};

INSTANTIATE_TEST_SUITE_P(Methods, Revolutions,
                         testing::Values(Method{"gauss_seidel", "float"}, Method{"gauss_seidel", "double"},
                                         Method{"gauss_seidel", "float", true}, Method{"gauss_seidel", "double", true},
                                         Method{"small_steps", "float"}, Method{"small_steps", "double"},
                                         Method{"jacobi", "float"}, Method{"jacobi", "double"},
                                         Method{"accelerated_gradient", "double"}, Method{"nsgs", "double"},
                                         Method{"reduced_nsgs", "double"}));

constexpr JointKind kinds[] = {JOINT_HINGE, JOINT_PLANAR, JOINT_UNIVERSAL};

TEST_P(Revolutions, AMotorDrivesFiveOfThem) {
  for (const JointKind kind : kinds) {
    for (const double sign : {1.0, -1.0}) {
      Scene scene = wheel(1.0 / 240, kind);
      scene.bodies[0].angular_velocity = {0, 0, sign * 10 * pi};
      scene.joints[0].motor_speed = sign * 10 * pi;
      scene.joints[0].motor_force = 10;
      EXPECT_NEAR(angle_after(scene, 1), sign * 10 * pi, 10 * rounding()) << name_of(kind);
    }
  }
}

// More than half a revolution in a sub-step is followed too, from the first step on.
TEST_P(Revolutions, AnySpeedIsFollowed) {
  Scene scene = wheel(1.0 / 60);
  scene.bodies[0].angular_velocity = {0, 0, 1000};
  World world = world_of(scene);
  EXPECT_NEAR(angle_in(world), 0, 1e-12);
  world.step(60);
  EXPECT_NEAR(angle_in(world), 1000, 100 * rounding());
}

TEST_P(Revolutions, LimitsAtThreeOfThemStopThere) {
  for (const JointKind kind : kinds) {
    for (const double sign : {1.0, -1.0}) {
      Scene scene = wheel(1.0 / 240, kind);
      scene.joints[0].limited = true;
      scene.joints[0].low = -6 * pi;
      scene.joints[0].high = 6 * pi;
      scene.bodies[0].angular_velocity = {0, 0, sign * 12};
      World world = world_of(scene);
      world.step(240);
      EXPECT_NEAR(angle_in(world), sign * 12, 10 * rounding()) << name_of(kind);
      world.step(240);
      EXPECT_NEAR(angle_in(world), sign * 6 * pi, 1e-3) << name_of(kind);
      world.step(240);
      EXPECT_NEAR(angle_in(world), sign * 6 * pi, 1e-3) << name_of(kind);
    }
  }
}

// Half a revolution to either side lets it go nowhere beyond.
TEST_P(Revolutions, LimitsAtHalfOfOneStopIt) {
  Scene scene = wheel();
  scene.joints[0].limited = true;
  scene.joints[0].low = -pi;
  scene.joints[0].high = pi;
  scene.joints[0].motor_speed = 20;
  scene.joints[0].motor_force = 0.5;
  EXPECT_NEAR(angle_after(scene, 2), pi, 2e-3);
}

// A spring of two revolutions, let go: x = 4 pi (1 - cos w t), w = sqrt(k / I) = 2 pi.
TEST_P(Revolutions, ASpringPullsThroughThemWithItsPeriod) {
  Scene scene = wheel(1.0 / 960);
  const bool second_order = scene.settings.solver != Solver::small_steps, is_float = rounding() > 1e-6;
  if (second_order) scene.settings.integrator = Integrator::trapezoidal;
  // in float springs of short sub-steps are up to 1 % too weak
  const double tolerance = (second_order ? 5e-3 : 0.2) + (is_float ? 0.6 : 0);
  scene.joints[0].spring = JointSpring{.stiffness = inertia * 4 * pi * pi, .rest = 4 * pi};
  World world = world_of(scene);
  for (int quarter = 1; quarter <= 8; ++quarter) {
    world.step(240);
    EXPECT_NEAR(angle_in(world), 4 * pi * (1 - std::cos(quarter * pi / 2)), tolerance) << quarter;
  }
}

// However stiff: a step of the stiff one would go all the way at once.
TEST_P(Revolutions, AServoGoesToSevenRadians) {
  for (const double stiffness : {10.0, 1e5}) {
    Scene scene = wheel(1.0 / 60);
    scene.joints[0].spring =
        JointSpring{.stiffness = stiffness, .damping = 2 * std::sqrt(stiffness * inertia), .rest = 7};
    EXPECT_NEAR(angle_after(scene, 4), 7, 1e-4) << stiffness;
  }
}

// Locked, or limited, far from where it is: closing it by poses goes a radian in a sub-step.
TEST_P(Revolutions, WhatIsFarFromItsLimitsGoesThere) {
  for (const double width : {0.0, 1.0}) {
    for (const double sign : {1.0, -1.0}) {
      Scene scene = wheel(1.0 / 60);
      scene.joints[0].limited = true;
      scene.joints[0].low = sign * 4 * pi - width;
      scene.joints[0].high = sign * 4 * pi + width;
      EXPECT_NEAR(angle_after(scene, 3), sign * (4 * pi - width), 2e-3) << width;
    }
  }
}

TEST_P(Revolutions, AStartIsOfAnyNumberOfThem) {
  Scene scene = wheel();
  const double start = 4 * pi + 0.5;
  scene.bodies[0].orientation = {0, 0, std::sin(0.25), std::cos(0.25)};
  scene.bodies[0].angular_velocity = {0, 0, -4};
  scene.joints[0].reference_poses = ReferencePoses{};
  scene.joints[0].start = start;
  scene.joints[0].limited = true;
  scene.joints[0].low = 3 * pi;
  scene.joints[0].high = 5 * pi;
  World world = world_of(scene);
  EXPECT_NEAR(angle_in(world), start, rounding());
  world.step(240);
  EXPECT_NEAR(angle_in(world), 3 * pi, 1e-3);
}

// ---- a world of the library

class RevolutionsOfWorlds : public testing::Test {
 protected:
  RevolutionsOfWorlds() : world(wheel(), in_double()), body(world.bodies()[0]), axle(world.joints()[0]) {}

  static Scene wheel() {
    Scene scene = joint_scene({bare_body({0, 0, 0})}, {joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0})}, 0.01);
    scene.name = scene.source = "wheel";
    scene.gravity = {0, 0, 0};
    scene.bodies[0].angular_velocity = {0, 0, 20};
    return scene;
  }
  double angle() { return world.state(axle).coordinate; }

  World world;
  BodyHandle body;
  JointHandle axle;
};

TEST_F(RevolutionsOfWorlds, SnapshotsKeepThem) {
  world.step(100);
  const std::uint64_t hash = world.state_hash();
  const Snapshot saved = world.save();
  world.step(50);
  EXPECT_NEAR(angle(), 30, 1e-9);
  world.restore(saved);
  EXPECT_NEAR(angle(), 20, 1e-9);
  EXPECT_EQ(world.state_hash(), hash);
}

TEST_F(RevolutionsOfWorlds, ChangesKeepThem) {
  world.step(100);
  const BodyHandle other = world.add(box_at({5, 0, 0}));
  EXPECT_NEAR(angle(), 20, 1e-9);
  world.step(50);
  EXPECT_NEAR(angle(), 30, 1e-9);
  JointDescription limited = world.description(axle);
  limited.limited = true;
  limited.low = 0;
  limited.high = 35;
  world.change(axle, limited);
  world.remove(other);
  world.step(50);
  EXPECT_NEAR(angle(), 35, 1e-6);
}

// Of all that the new pose allows the angle is the one nearest to what it was.
TEST_F(RevolutionsOfWorlds, WhatIsTeleportedKeepsThem) {
  world.step(100);
  world.teleport(body, {{0, 0, 0}, {0, 0, 0, 1}});
  EXPECT_NEAR(angle(), 6 * pi, 1e-9);
  world.step(10);
  EXPECT_NEAR(angle(), 6 * pi, 1e-9);
}

// No velocity that is set is taken for a way that was gone.
TEST_F(RevolutionsOfWorlds, AVelocityThatIsSetAddsNone) {
  for (const double w : {2000.0, -2000.0, 0.0}) {
    const double before = angle();
    world.set_velocity(body, {{0, 0, 0}, {0, 0, w}});
    EXPECT_NEAR(angle(), before, 1e-9) << w;
    world.step();
    EXPECT_NEAR(angle(), before + 0.01 * w, 1e-7) << w;
  }
}

TEST_F(RevolutionsOfWorlds, AJointThatComesStartsWithNone) {
  world.set_velocity(body, {{0, 0, 0}, {0, 0, 2000}});
  world.step(3);
  const JointHandle late = world.add(joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0}), body);
  EXPECT_NEAR(world.state(late).coordinate, 0, 1e-9);
  world.step(3);
  EXPECT_NEAR(std::abs(world.state(late).coordinate), 60, 1e-6);
  EXPECT_NEAR(angle(), 120, 1e-6);
}

// A recording that begins late, with a fast velocity set within it, is replayed bit for bit.
TEST_F(RevolutionsOfWorlds, RecordingsKeepThem) {
  const TemporaryFolder folder;
  const std::string path = folder.file("wheel.h5");
  world.step(100);
  world.record(path);
  world.step(5);
  world.set_velocity(body, {{0, 0, 0}, {0, 0, 2000}});
  world.step(5);
  world.end_recording();
  u32 replayed = 0;
  replay<double>(RecordingReader(path), {}, [&](u32) { ++replayed; });
  EXPECT_EQ(replayed, 10u);
}

// Two states that differ by a revolution alone are two.
TEST_F(RevolutionsOfWorlds, TheHashTellsThem) {
  Scene scene = wheel();
  scene.bodies[0].angular_velocity = {0, 0, 0};
  World one(scene, in_double());
  scene.joints[0].start = 2 * pi;
  World other(scene, in_double());
  EXPECT_NE(one.state_hash(), other.state_hash());
}

// ---- twins

template <class real>
void expect_twins(const Settings& settings) {
  Scene scene;
  scene.settings = settings;
  scene.gravity = {0, 0, -9.81};
  Random random(3);
  for (u32 i = 0; i < 24; ++i) {
    const JointKind kind = kinds[i % 3];
    scene.bodies.push_back(bare_body({2.0 * i, 0, 0.5}, {0.1, 0.2, 0.3}));
    scene.bodies.back().angular_velocity = {0, 0, random.between(-400, 400)};
    JointDescription joint = joint_of(kind, NONE, i, {2.0 * i, 0, 0.5});
    joint.start = random.between(-40, 40);
    const double at = random.between(-30, 30);
    if (i % 4 == 0) joint.spring = JointSpring{.stiffness = 30, .damping = 0.1, .rest = at};
    if (i % 4 == 1) joint.limited = true, joint.low = at, joint.high = at + 10;
    if (i % 4 == 2) joint.limited = true, joint.low = joint.high = at;
    scene.joints.push_back(joint);
  }
  expect_twins_agree(compile<real>(scene), 20, launch_options({{1, 7}, {8, 0}}));
}

TEST(RevolutionsOfTwins, KernelsMatchTheReference) {
  Settings settings;
  settings.dt = 1.0 / 60;
  expect_twins<float>(settings);
  expect_twins<double>(settings);
  settings.joint_solver = JointSolver::direct;
  expect_twins<float>(settings);
  settings.joint_solver = JointSolver::sweeps;
  replace_solver(settings, Solver::small_steps);
  expect_twins<double>(settings);
}

// What has no such angle has no room for it.
TEST(RevolutionsOfTwins, OthersPayNothing) {
  const Scene scene = joint_scene({bare_body({0, 0, 0})}, {joint_of(JOINT_SLIDER, NONE, 0, {0, 0, 0})}, 0.01);
  EXPECT_TRUE(compile<float>(scene).buffers.joint_angles.empty());
}

}  // namespace
}  // namespace lockstep::test::revolutions_test
