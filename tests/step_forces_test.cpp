// Forces and impulses that worlds tell are those of the whole step, whatever solves it and in however many sub-steps.
#include <cmath>

#include "host/scene/settings.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::step_forces_test {
namespace {

constexpr double g = 9.81;

struct Method {
  const char* name;
  Solver solver;
  FrictionModel friction_model = FrictionModel::cones;
  JointSolver joint_solver = JointSolver::sweeps;
};
constexpr Method methods[] = {{"small_steps", Solver::small_steps},
                              {"gauss_seidel", Solver::gauss_seidel},
                              {"jacobi", Solver::jacobi},
                              {"dense", Solver::dense_gauss_seidel},
                              {"cells", Solver::cell_gauss_seidel},
                              {"gradient", Solver::accelerated_gradient},
                              {"oracle", Solver::nsgs},
                              {"direct", Solver::gauss_seidel, FrictionModel::cones, JointSolver::direct},
                              {"patches", Solver::gauss_seidel, FrictionModel::patches},
                              {"soft_patches", Solver::small_steps, FrictionModel::patches}};

struct Case {
  Method method;
  bool in_float;
  u32 substeps;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Method& method : methods) {
    for (const bool in_float : {false, true}) {
      if (in_float && is_oracle(method.solver)) continue;
      for (const u32 substeps : {1u, 4u, 5u, 12u}) all.push_back({method, in_float, substeps});
    }
  }
  return all;
}

class StepForces : public testing::TestWithParam<Case> {
 protected:
  // How near a closed form what is told comes, as a part of it: what sweeps leave, and what rounding does to friction.
  double tolerance() const { return GetParam().in_float ? 2e-3 : 1e-3; }

  World world(Scene scene) const {
    Settings& settings = scene.settings;
    replace_solver(settings, GetParam().method.solver);
    settings.substeps = GetParam().substeps;
    if (!is_oracle(settings.solver) && settings.solver != Solver::small_steps) settings.iterations = 60;
    if (settings.solver == Solver::accelerated_gradient) settings.iterations = 400;
    settings.friction_model = GetParam().method.friction_model;
    settings.joint_solver = GetParam().method.joint_solver;
    return World(scene, {.device = "reference", .precision = GetParam().in_float ? "float" : "double"});
  }
};

// A lift that rises faster and faster, a kinematic slab: m (g + a).
TEST_P(StepForces, OfALiftThatAccelerates) {
  const double a = 2;
  Scene scene = ground_scene();
  scene.bodies.clear();
  World lift = world(scene);
  BodyDescription slab = box_at({0, 0, -0.5});
  slab.kind = BODY_KINEMATIC;
  slab.mass = 0;
  const BodyHandle cabin = lift.add(slab), load = lift.add(box_at({0, 0, 0.5}, 10));
  for (u32 i = 0; i < 60; ++i) {
    lift.set_velocity(cabin, {{0, 0, a * lift.time_step() * (i + 1)}, {0, 0, 0}});
    lift.step();
  }
  const Vector3 force = lift.contact_force(load);
  EXPECT_NEAR(force[2], 10 * (g + a), tolerance() * 10 * (g + a));
  EXPECT_NEAR(lift.contact_force(cabin)[2], -force[2], 1e-12);
  EXPECT_NEAR(lift.contact_force(load, 0)[2], force[2], 1e-12);
}

// Gravity that leans by an angle: what stands has m g cos and m g sin, what slides m g cos and mu times that.
TEST_P(StepForces, OnAnIncline) {
  for (const double friction : {0.8, 0.2}) {
    const double angle = 0.4, mass = 3;
    Scene scene = ground_scene(friction);
    scene.gravity = {g * std::sin(angle), 0, -g * std::cos(angle)};
    World slope = world(scene);
    const BodyHandle box = slope.add(box_at({0, 0, 0.5}, mass));
    slope.step(100);
    const Vector3 force = slope.contact_force(box);
    const double normal = mass * g * std::cos(angle), least = std::min(mass * g * std::sin(angle), friction * normal);
    EXPECT_NEAR(force[2], normal, tolerance() * normal);
    EXPECT_NEAR(force[0], -least, 4 * tolerance() * normal) << friction;
  }
}

// Three boxes on each other: each bears what is above it, and itself.
TEST_P(StepForces, OfAStack) {
  World stack = world(ground_scene());
  std::vector<BodyHandle> boxes;
  for (int i = 0; i < 3; ++i) boxes.push_back(stack.add(box_at({0, 0, 0.5 + i}, 2)));
  stack.step(200);
  EXPECT_NEAR(stack.contact_force(*stack.find("floor"))[2], -6 * g, 10 * tolerance() * g);
  for (const BodyHandle box : boxes) EXPECT_NEAR(stack.contact_force(box)[2], 2 * g, 10 * tolerance() * g);
  double lowest = 0;
  for (const BodyContact& contact : stack.contacts())
    if (contact.a == boxes[1] && contact.b == boxes[2]) lowest -= contact.impulse[2];
  EXPECT_NEAR(std::abs(lowest), 2 * g * stack.time_step(), 10 * tolerance() * g * stack.time_step());
}

// In each step of a box that falls, lands and slides to rest m (v' - v) = (m g + F) dt, and so all together are m g T.
TEST_P(StepForces, OfALandingAreItsMomentum) {
  const double mass = 20;
  Scene scene = ground_scene();
  World ground = world(scene);
  BodyDescription falling = box_at({0, 0, 1}, mass);
  falling.velocity = {1, 0, 0};
  const BodyHandle box = ground.add(falling);
  const double dt = ground.time_step(), rounding = GetParam().in_float ? 3e-4 : 1e-10;
  Vector3 before = falling.velocity;
  for (u32 i = 0; i < 80; ++i) {
    ground.step();
    const Vector3 force = ground.contact_force(box), after = ground.velocity(box).linear;
    EXPECT_NEAR(mass * (after[2] - before[2]), (force[2] - mass * g) * dt, rounding) << i;
    EXPECT_NEAR(mass * (after[0] - before[0]), force[0] * dt, rounding) << i;
    before = after;
  }
  EXPECT_NEAR(before[2], 0, 0.01) << "it has landed";
}

// An impact that a step has whole is told whole: a ball of 20 kg that stops from 9.81 m/s leaves 196.2 N s.
TEST_P(StepForces, OfAnImpactAreTheWholeBlow) {
  Scene scene = ground_scene();
  scene.gravity = {0, 0, 0};
  scene.settings.impact_speed = 1;
  scene.settings.dt = 0.02;
  World ground = world(scene);
  BodyDescription ball = ball_at({0, 0, 0.5 + 0.009 * g});
  make_solid_of_mass(ball, 20);
  ball.velocity = {0, 0, -g};
  ground.add(ball);
  ground.step();
  const auto events = ground.events();
  ASSERT_EQ(events.size(), 2u) << "it begins to touch, with a blow";
  const double stopped = g + ground.velocity(ground.bodies()[1]).linear[2];
  EXPECT_NEAR(events[1].impact->impulse[2], 20 * stopped, 2e-4 * 20 * stopped);
  if (GetParam().substeps > 2) {
    EXPECT_NEAR(events[1].impact->impulse[2], 196.2, 0.2);
  }
}

// What hangs by a joint from a lift: m (g + a), and the moment of a fixed one that holds it by its side, m (g + a) l.
TEST_P(StepForces, OfAJointOnALift) {
  const double a = 2, mass = 10;
  Scene scene = empty_scene();
  scene.gravity = {0, 0, -g};
  World lift = world(scene);
  BodyDescription cabin;
  cabin.kind = BODY_KINEMATIC;
  const BodyHandle base = lift.add(cabin), load = lift.add(box_at({0.3, 0, 0}, mass));
  const JointHandle joint = lift.add({.kind = JOINT_FIXED}, base, load);
  for (u32 i = 0; i < 60; ++i) {
    lift.set_velocity(base, {{0, 0, a * lift.time_step() * (i + 1)}, {0, 0, 0}});
    lift.step();
  }
  const JointState state = lift.state(joint);
  const double force = mass * (g + a), rough = 3 * tolerance();
  EXPECT_NEAR(state.force[2], force, rough * force);
  EXPECT_NEAR(state.force[0], 0, rough * force);
  EXPECT_NEAR(state.torque[1], -0.3 * force, rough * force) << "about the anchor, on b";
}

// A ball on a rod that swings from the level: m (g cos + v^2 / l), the rod as a ball joint and as a distance joint.
TEST_P(StepForces, OfAPendulum) {
  for (const JointKind kind : {JOINT_BALL, JOINT_DISTANCE}) {
    const double length = 1, mass = 2;
    Scene scene = empty_scene(0.002);
    scene.gravity = {0, 0, -g};
    World swing = world(scene);
    const BodyHandle bob = swing.add(box_at({length, 0, 0}, mass));
    JointDescription rod = {.kind = kind, .anchor_a = {length, 0, 0}, .anchor_b = {0, 0, 0}};
    if (kind == JOINT_BALL) rod.anchor_a = {0, 0, 0};
    if (kind == JOINT_DISTANCE) rod.limited = true, rod.low = rod.high = length;
    const JointHandle joint = swing.add(rod, bob);
    for (u32 i = 0; i < 250; ++i) {
      const Vector3 x = swing.pose(bob).position;
      swing.step();
      if (i % 50 != 49) continue;
      const Vector3 v = swing.velocity(bob).linear, after = swing.pose(bob).position;
      const Vector3 middle = exact::scale(0.5, exact::add(x, after));
      const double r = exact::length(middle), pull = mass * (-g * middle[2] / r + exact::dot(v, v) / r);
      const JointState state = swing.state(joint);
      const double told = kind == JOINT_BALL ? exact::dot(state.force, middle) / r : state.drive;
      const double rough = GetParam().method.solver == Solver::accelerated_gradient ? 0.12 : 0.03;  // in float
      EXPECT_NEAR(std::abs(told), pull, rough * mass * g) << kind << ", step " << i;
    }
  }
}

// A motor brakes a wheel by its full torque until it stands: drive, over the step, is what the wheel loses.
TEST_P(StepForces, OfAMotorThatBrakes) {
  Scene scene = empty_scene();
  World shop = world(scene);
  BodyDescription wheel = box_at({0, 0, 0}, 6);  // I = 1 kg m^2
  wheel.angular_velocity = {0, 0, 2};
  const BodyHandle body = shop.add(wheel);
  const JointHandle axle = shop.add({.kind = JOINT_HINGE}, body);
  shop.set_motor(axle, 0, 5);
  double before = 2;
  for (u32 i = 0; i < 50; ++i) {
    shop.step();
    const double after = shop.velocity(body).angular[2], drive = shop.state(axle).drive;
    EXPECT_NEAR(drive * shop.time_step(), before - after, GetParam().in_float ? 2e-6 : 1e-12) << i;
    if (i < 39) {
      EXPECT_NEAR(drive, 5, 5 * tolerance()) << i;
    }
    before = after;
  }
  EXPECT_NEAR(before, 0, 1e-5);
}

// A box that hangs still by a spring, k x = m g.
TEST_P(StepForces, OfASpring) {
  const double stiffness = 400, mass = 2;
  Scene scene = empty_scene();
  scene.gravity = {0, 0, -g};
  World shop = world(scene);
  const BodyHandle body = shop.add(box_at({0, 0, 0}, mass));
  const JointSpring spring = {.stiffness = stiffness, .rest = -mass * g / stiffness};
  const JointHandle joint = shop.add({.kind = JOINT_SLIDER, .spring = spring}, body);
  shop.step(10);
  EXPECT_NEAR(shop.state(joint).drive, -mass * g, 1e-3 * mass * g) << "on the world";
}

std::string name_of_case(const testing::TestParamInfo<Case>& info) {
  const Case& c = info.param;
  return std::string(c.method.name) + (c.in_float ? "_float_" : "_double_") + std::to_string(c.substeps);
}

INSTANTIATE_TEST_SUITE_P(Methods, StepForces, testing::ValuesIn(cases()), name_of_case);

// ---- of which time, and of what sleeps, comes and goes

Scene slept_scene(Forces forces) {
  Scene scene = ground_scene();
  scene.settings.forces = forces;
  scene.settings.sleeping = SleepSettings{.after = 0.2};
  return scene;
}

TEST(ForcesSetting, TellsTheLastSubStepOnRequest) {
  for (const Forces forces : {Forces::automatic, Forces::step, Forces::substep}) {
    Scene scene = ground_scene();
    scene.settings.forces = forces;
    World world(scene, in_double());
    const BodyHandle box = world.add(box_at({0, 0, 0.5}, 2));
    world.step(100);
    EXPECT_EQ(world.substeps(), 5u);
    EXPECT_DOUBLE_EQ(world.substep_length(), 0.002);
    double impulse = 0;
    for (const BodyContact& contact : world.contacts()) impulse += contact.impulse[2];
    const double time = forces == Forces::substep ? world.substep_length() : world.time_step();
    EXPECT_NEAR(impulse, 2 * g * time, 1e-3 * time);
    EXPECT_NEAR(world.contact_force(box)[2], 2 * g, 1e-3);
  }
}

TEST(ForcesSetting, ChangesNoBit) {
  std::vector<std::uint64_t> hashes;
  for (const Forces forces : {Forces::step, Forces::substep}) {
    World world(slept_scene(forces), in_double());
    world.add(box_at({0, 0, 0.7}, 2));
    world.add(box_at({0.3, 0, 1.8}, 2));
    world.step(30);
    hashes.push_back(world.state_hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(ForcesSetting, SleepersTellWhatTheyLastCarriedForAsLong) {
  for (const Forces forces : {Forces::step, Forces::substep}) {
    World world(slept_scene(forces), in_double());
    const BodyHandle box = world.add(box_at({0, 0, 0.5}, 2)), weight = world.add(box_at({3, 0, 2}, 4));
    const JointHandle rope = world.add({.kind = JOINT_FIXED, .anchor_a = {3, 0, 2}, .anchor_b = {3, 0, 2}}, weight);
    for (u32 i = 0; i < 100; ++i) {
      world.step();
      if (i < 15) continue;
      EXPECT_NEAR(world.contact_force(box)[2], 2 * g, 2e-3 * g) << i;
      EXPECT_NEAR(world.state(rope).force[2], -4 * g, 2e-2 * g) << i << ", on the world";
    }
    EXPECT_TRUE(world.is_asleep(box));
    EXPECT_TRUE(world.is_asleep(weight));
  }
}

TEST(ForcesSetting, ASnapshotKeepsThem) {
  World world(ground_scene(), in_double());
  const BodyHandle box = world.add(box_at({0, 0, 0.6}, 2)), bob = world.add(box_at({4, 0, 3}, 1));
  const JointHandle joint = world.add({.kind = JOINT_BALL, .anchor_a = {3, 0, 3}, .anchor_b = {3, 0, 3}}, bob);
  world.step(20);
  const Vector3 force = world.contact_force(box), pull = world.state(joint).force;
  EXPECT_GT(force[2], g);
  const Snapshot snapshot = world.save();
  world.step(7);
  EXPECT_NE(world.state(joint).force, pull);
  world.restore(snapshot);
  EXPECT_EQ(world.contact_force(box), force);
  EXPECT_EQ(world.state(joint).force, pull);
}

TEST(ForcesSetting, AJointTellsItsLastForceOnceOthersHaveCome) {
  Scene scene = empty_scene();
  scene.gravity = {0, 0, -g};
  replace_solver(scene.settings, Solver::small_steps);
  World world(scene, in_double());
  const BodyHandle bob = world.add(box_at({0, 0, -1}, 3));
  const JointHandle joint = world.add({.kind = JOINT_BALL}, bob);
  EXPECT_EQ(world.state(joint).force, (Vector3{0, 0, 0}));
  world.step(100);
  EXPECT_NEAR(world.state(joint).force[2], -3 * g, 0.05 * g);
  world.add(box_at({9, 0, 0}));
  EXPECT_NEAR(world.state(joint).force[2], -3 * g, 0.05 * g);
}

TEST(ForcesSetting, AShapeThatABodyLacksIsRefused) {
  World world(ground_scene(), in_double());
  const BodyHandle box = world.add(box_at({0, 0, 0.5}, 2));
  EXPECT_EQ(refusal([&] { world.contact_force(box, 1); }), "body with the handle 1: has no shape 1, its shapes are 1");
}

}  // namespace
}  // namespace lockstep::step_forces_test
