// Joints that lock velocities alone: skates, and balls that roll without a slip.
#include <gtest/gtest.h>

#include <cmath>

#include "host/report/joints.hpp"
#include "tests/bodies.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::non_holonomic_test {
namespace {

template <class real>
class NonHolonomic : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(NonHolonomic, Precisions);

constexpr double slope = 2, angular_velocity = 1.5;  // m/s^2 down the plane, rad/s

// On a plane that slopes down along y: an edge along x, under the centre of mass, and a spin that nothing changes.
Scene skater(double dt) {
  BodyDescription body = bare_body({0, 0, 0}, {0.1, 0.1, 0.3});
  body.angular_velocity = {0, 0, angular_velocity};
  Scene scene = joint_scene(
      {body}, {joint_of(JOINT_PLANAR, NONE, 0, {0, 0, 0}), joint_of(JOINT_SKATE, NONE, 0, {0, 0, 0}, {0, 1, 0})}, dt);
  scene.gravity = {0, slope, -9};
  return scene;
}

// With the edge at the angle phi = w t the speed along it is (g / w) (1 - cos phi): it comes to rest where it has
// turned once, at the height where it began, and goes on sideways, never down by more than 2 g / w^2 (Neimark, Fufaev,
// Dynamics of Nonholonomic Systems, 1972).
struct OnSlope {
  double x, y;
};
OnSlope on_slope(double t) {
  const double phi = angular_velocity * t, scale = slope / (angular_velocity * angular_velocity),
               versine = 1 - std::cos(phi);
  return {scale * (std::sin(phi) - phi / 2 - std::sin(2 * phi) / 4), scale * versine * versine / 2};
}

template <class real>
double off_slope(double dt, Integrator integrator, u32 substeps, double duration) {
  Scene scene = substeps > 1 ? with_small_steps(skater(dt), substeps) : skater(dt);
  scene.settings.integrator = integrator;
  double worst = 0, skid = 0;
  watch_steps<real>(scene, static_cast<u32>(std::lround(duration / dt)), [&](const Buffers<real>& b, u32 i) {
    const OnSlope exact = on_slope((i + 1) * dt);
    const auto x = position(b, 0);
    worst = std::max(worst, std::hypot(double(x[0]) - exact.x, double(x[1]) - exact.y));
    const double heading = angular_velocity * (i + 0.5) * dt;  // of the middle of the step
    skid = std::max(
        skid, std::abs(-std::sin(heading) * double(b.motions[0].v[0]) + std::cos(heading) * double(b.motions[0].v[1])));
  });
  EXPECT_LT(skid, 4 * slope * dt);
  return worst;
}

TYPED_TEST(NonHolonomic, ASkateOnASlopeGoesSideways) {
  using real = TypeParam;
  const double two_revolutions = 4 * exact::pi / angular_velocity;
  for (const u32 substeps : {1u, 4u}) {
    const double coarse = off_slope<real>(0.02, Integrator::semi_implicit_euler, substeps, two_revolutions);
    const double fine = off_slope<real>(0.01, Integrator::semi_implicit_euler, substeps, two_revolutions);
    EXPECT_LT(fine, 0.02 / substeps) << substeps;
    EXPECT_GT(coarse / fine, 1.8) << substeps;
  }
  const double coarse = off_slope<real>(0.02, Integrator::trapezoidal, 1, two_revolutions);
  EXPECT_LT(coarse, 2.6e-3);
  EXPECT_GT(coarse / off_slope<real>(0.01, Integrator::trapezoidal, 1, two_revolutions), 3.5);
}

// Chaplygin's sleigh: the edge a behind the centre of mass, on level ice. Of what turns at first and does not go, with
// kappa = 1 + I / (m a^2): the speed along the edge is V tanh(s t), the spin W sech(s t), V = a W sqrt(kappa) and
// s = V / (a kappa) (Bloch, Nonholonomic Mechanics and Control, 2003, 1.7).
TYPED_TEST(NonHolonomic, ASleighEndsInAStraightLine) {
  using real = TypeParam;
  const double a = 0.4, inertia = 0.2, first = 3, dt = 1.0 / 240;
  BodyDescription body = bare_body({0, 0, 0}, {0.1, 0.1, inertia});
  body.velocity = {0, a * first, 0};
  body.angular_velocity = {0, 0, first};
  Scene scene = joint_scene(
      {body}, {joint_of(JOINT_PLANAR, NONE, 0, {0, 0, 0}), joint_of(JOINT_SKATE, NONE, 0, {-a, 0, 0}, {0, 1, 0})}, dt);
  scene.settings.integrator = Integrator::trapezoidal;
  scene.settings.iterations = 40;
  const double kappa = 1 + inertia / (a * a), last = a * first * std::sqrt(kappa), s = last / (a * kappa);
  double heading = 0;
  watch_steps<real>(scene, 960, [&](const Buffers<real>& b, u32 i) {
    const double t = (i + 1) * dt;
    heading = first / s * std::atan(std::sinh(s * t));
    const double along = std::cos(heading) * double(b.motions[0].v[0]) + std::sin(heading) * double(b.motions[0].v[1]);
    ASSERT_NEAR(double(b.motions[0].w[2]), first / std::cosh(s * t), 2e-3) << i;
    ASSERT_NEAR(along, last * std::tanh(s * t), 2e-3) << i;
  });
  EXPECT_GT(s * 4, 5);  // it goes straight by then
}

// Down a slope: 5/7 g sin(alpha) of a solid ball. Nothing but the joint holds it on the slope.
TYPED_TEST(NonHolonomic, ABallRollsDownASlope) {
  using real = TypeParam;
  const double radius = 0.25, dt = 0.01;
  for (const u32 substeps : {1u, 4u}) {
    const double share = 0.4 * radius * radius;
    JointDescription roll = joint_of(JOINT_ROLLING, NONE, 0, {0, 0, 0});
    roll.radius = radius;
    Scene scene = joint_scene({bare_body({0, 0, 0}, {share, share, share})}, {roll}, dt);
    scene.gravity = {3, 0, -9};
    if (substeps > 1) scene = with_small_steps(scene, substeps);
    const InitialState<real> state = compile<real>(scene);
    const Buffers<real> b = after_steps<real>(scene, 200);
    const double relative = sizeof(real) == 4 ? 1e-5 : 1e-12;
    EXPECT_NEAR(double(b.motions[0].v[0]), 5.0 / 7 * 3 * 2, 5 * relative);
    EXPECT_NEAR(double(b.motions[0].w[1]), 5.0 / 7 * 3 * 2 / radius, 20 * relative);
    EXPECT_NEAR(double(position(b, 0)[2]), 0, relative);
    const JointMeasures joint = measure_joint(b, state.params, 0);
    EXPECT_NEAR(joint.force.x(), -2.0 / 7 * 3, 1e-3);  // what rubs at the slope
    EXPECT_NEAR(joint.force.z(), 9, 1e-3);
    EXPECT_NEAR(joint.torque.y(), 2.0 / 7 * 3 * radius, 1e-3);  // about the centre
    EXPECT_NEAR(joint.drift.separation, 0, relative);           // rolling on is not coming apart
  }
}

// On a turntable of rate W a ball goes round in a circle at 2/7 W, wherever that is, and is not thrown out (Earnshaw
// 1844; Weltner, Stable circular orbits of freely moving balls on rotating discs, Am. J. Phys. 47, 1979).
TYPED_TEST(NonHolonomic, ABallOnATurntableGoesRound) {
  using real = TypeParam;
  const double radius = 0.1, table = 4, dt = 1.0 / 240, rate = 2.0 / 7 * table;
  const double share = 0.4 * radius * radius;
  BodyDescription disc;
  disc.kind = BODY_KINEMATIC;
  disc.angular_velocity = {0, 0, table};
  BodyDescription ball = bare_body({0.5, 0, 0.1}, {share, share, share});
  const Vector3 v = {0.1, 0.7, 0}, under = exact::subtract(exact::cross({0, 0, table}, ball.position), v);
  ball.velocity = v;
  ball.angular_velocity = {under[1] / radius, -under[0] / radius, 0};  // what it touches with moves with the table
  JointDescription roll = joint_of(JOINT_ROLLING, 0, 1, ball.position);
  roll.radius = radius;
  for (const u32 substeps : {1u, 8u}) {
    Scene scene = joint_scene({disc, ball}, {roll}, dt);
    if (substeps > 1)
      scene = with_small_steps(scene, substeps);
    else
      scene.settings.integrator = Integrator::trapezoidal;
    double worst = 0, height = 0;
    watch_steps<real>(scene, 1440, [&](const Buffers<real>& b, u32 i) {
      // v = v0 turned by rate t
      const double angle = rate * (i + 1) * dt, c = std::cos(angle), s = std::sin(angle);
      const double x = ball.position[0] + (v[0] * s - v[1] * (1 - c)) / rate;
      const double y = ball.position[1] + (v[0] * (1 - c) + v[1] * s) / rate;
      const auto at = position(b, 1);
      worst = std::max(worst, std::hypot(double(at[0]) - x, double(at[1]) - y));
      height = std::max(height, std::abs(double(at[2]) - ball.position[2]));
    });
    EXPECT_LT(worst, substeps > 1 ? 5e-3 : 1e-3);
    EXPECT_LT(height, 1e-5);
  }
}

}  // namespace
}  // namespace lockstep::test::non_holonomic_test
