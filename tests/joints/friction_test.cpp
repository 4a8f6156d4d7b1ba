// Dry friction in joints.
#include <gtest/gtest.h>

#include <cmath>

#include "host/report/joints.hpp"
#include "tests/bodies.hpp"
#include "tests/joints/joint_scene.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::test::friction_test {
namespace {

constexpr double dt = 1.0 / 240;

template <class real>
class JointFriction : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(JointFriction, Precisions);

// I w / M seconds, evenly slower; then it stands.
TYPED_TEST(JointFriction, AFlywheelStops) {
  using real = TypeParam;
  const double torque = 0.3, moment = 0.2, speed = 2;
  for (const u32 substeps : {1u, 4u}) {
    Scene scene =
        joint_scene({bare_body({0, 0, 0}, {0.1, 0.1, moment})}, {joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0})}, dt);
    scene.bodies[0].angular_velocity = {0, 0, -speed};
    scene.joints[0].friction = torque;
    if (substeps > 1) scene = with_small_steps(scene, substeps);
    const InitialState<real> state = compile<real>(scene);
    EXPECT_FALSE(joints_conserve_energy(state.buffers, state.params));
    watch_steps<real>(scene, 400, [&](const Buffers<real>& b, u32 i) {
      EXPECT_NEAR(double(b.motions[0].w[2]), -std::max(speed - torque / moment * (i + 1) * dt, 0.0), 5e-5) << i;
      if (i < 300) {
        EXPECT_NEAR(measure_joint(b, state.params, 0).drive, torque, 1e-5) << i;
      }
    });
  }
}

// On a slope: it holds what is not more than itself, and takes itself from what is.
TYPED_TEST(JointFriction, ASliderSticksOrSlides) {
  using real = TypeParam;
  const double slope = 0.4, pull = 9.81 * std::sin(slope);
  for (const double force : {1.01 * pull, 0.6 * pull}) {
    Scene scene = joint_scene({bare_body({0, 0, 0})},
                              {joint_of(JOINT_SLIDER, NONE, 0, {0, 0, 0}, {std::cos(slope), 0, -std::sin(slope)})}, dt);
    scene.joints[0].friction = force;
    const InitialState<real> state = compile<real>(scene);
    const Buffers<real> b = after_steps<real>(scene, 240);
    const JointMeasures joint = measure_joint(b, state.params, 0);
    EXPECT_NEAR(joint.speed, std::max(pull - force, 0.0), 1e-4);
    EXPECT_NEAR(joint.drive, -std::min(force, pull), 1e-4);
  }
}

// A mass on a spring: each swing to the other side is 2 F / k shorter, until the spring is weaker than the friction.
TYPED_TEST(JointFriction, SwingsOfASpringShortenEvenly) {
  using real = TypeParam;
  const double k = 100, force = 1, step = 1e-3;
  Scene scene = joint_scene({bare_body({0, 0, 0.095})}, {joint_of(JOINT_SLIDER, NONE, 0, {0, 0, 0})}, step);
  scene.gravity = {0, 0, 0};
  scene.settings.integrator = Integrator::trapezoidal;
  scene.joints[0].reference_poses = {{0, 0, 0}, {0, 0, 0}};
  scene.joints[0].spring = {.stiffness = k};
  scene.joints[0].friction = force;
  std::vector<double> extremes = {0.095};
  double before = 0.095, last = 0;
  watch_steps<real>(scene, 3000, [&](const Buffers<real>& b, u32) {
    const double x = position(b, 0)[2], travel = x - before;
    if (travel * last < 0) extremes.push_back(before);
    if (std::abs(travel) > 1e-7) last = travel;
    before = x;
  });
  ASSERT_EQ(extremes.size(), 5u);
  for (std::size_t i = 0; i < extremes.size(); ++i)
    EXPECT_NEAR(std::abs(extremes[i]), 0.095 - 2 * force / k * double(i), 2e-4) << i;
  EXPECT_NEAR(before, extremes.back(), 0.021);
  EXPECT_LE(k * std::abs(before), force + 1e-3) << "it sticks where the spring is too weak";
}

// Of a cylindrical joint the travel is rubbed, of a universal one the first arm, of a screw the angle: a fine thread
// locks itself.
TYPED_TEST(JointFriction, ActsOnTheFreeCoordinate) {
  using real = TypeParam;
  BodyDescription body = bare_body({0, 0, 0}, {0.1, 0.1, 0.1});
  body.velocity = {0, 0, 1};
  body.angular_velocity = {0, 0, 1};
  Scene scene = joint_scene({body}, {joint_of(JOINT_CYLINDRICAL, NONE, 0, {0, 0, 0})}, dt);
  scene.gravity = {0, 0, 0};
  scene.joints[0].friction = 2;
  Buffers<real> b = after_steps<real>(scene, 60);
  EXPECT_NEAR(double(b.motions[0].v[2]), 0.5, 1e-5);
  EXPECT_NEAR(double(b.motions[0].w[2]), 1, 1e-6);

  scene.joints[0].kind = JOINT_UNIVERSAL;
  scene.bodies[0].velocity = {0, 0, 0};
  scene.bodies[0].angular_velocity = {0.5, 0, 1};
  scene.joints[0].friction = 0.1;
  b = after_steps<real>(scene, 24);
  EXPECT_NEAR(double(b.motions[0].w[2]), 0.9, 1e-3);
  EXPECT_NEAR(length(angular_velocity(b, 0)), std::hypot(0.5, 0.9), 1e-3);

  for (const double share : {0.9, 1.1}) {
    Scene nut = joint_scene({bare_body({0, 0, 0})}, {joint_of(JOINT_SCREW, NONE, 0, {0, 0, 0})}, dt);
    nut.joints[0].pitch = 0.02;
    nut.joints[0].friction = share * 9.81 * 0.02 / 6.283185307179586;
    b = after_steps<real>(nut, 240);
    const double a = 9.81 * 0.1 / (1 + 0.1 * std::pow(6.283185307179586 / 0.02, 2));
    EXPECT_NEAR(double(b.motions[0].v[2]), share < 1 ? -a : 0, 1e-3 * a) << share;
  }
}

// A body of little inertia, far from its hinge, that a torque drives against friction nearly as strong: what the torque
// alone would do to the body in a step, 23 rad/s, is not what it does. It gets (M - F) t / (I + m r^2).
TEST(LoadedHinge, AcceleratesByTheTorqueThatFrictionLeaves) {
  const double inertia = 0.01, arm = 0.5, torque = 14, friction = 12, time = 0.5;
  BodyDescription body = bare_body({arm, 0, 0}, {0.004, inertia, 0.012});
  Scene scene = joint_scene({body}, {joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0}, {0, 1, 0})}, 0);
  scene.name = scene.source = "hinge";
  scene.gravity = {0, 0, 0};
  scene.joints[0].friction = friction;
  const double speed = (torque - friction) * time / (inertia + arm * arm);
  struct Method {
    const char* solver;
    JointSolver joint_solver;
    Integrator integrator;
  };
  for (const auto& [solver, joint_solver, integrator] :
       {Method{"gauss_seidel", JointSolver::sweeps, Integrator::semi_implicit_euler},
        Method{"gauss_seidel", JointSolver::direct, Integrator::semi_implicit_euler},
        Method{"gauss_seidel", JointSolver::sweeps, Integrator::trapezoidal},
        Method{"small_steps", JointSolver::sweeps, Integrator::semi_implicit_euler}}) {
    for (const char* precision : {"float", "double"}) {
      for (const u32 rate : {60u, 120u, 240u}) {
        SCOPED_TRACE(std::string(solver) + " " + name_of(joint_solver) + " " + precision + " " + std::to_string(rate));
        replace_solver(scene.settings, *find_solver(solver));
        scene.settings.joint_solver = joint_solver;
        scene.settings.integrator = integrator;
        scene.settings.dt = 1.0 / rate;
        World world(scene, {.device = "reference", .precision = precision});
        world.set_load(world.bodies()[0], [&](double) { return Wrench{{0, 0, 0}, {0, torque, 0}}; });
        world.step(rate / 2);
        EXPECT_NEAR(world.velocity(world.bodies()[0]).angular[1], speed, 0.003 * speed);
      }
    }
  }
}

}  // namespace
}  // namespace lockstep::test::friction_test
