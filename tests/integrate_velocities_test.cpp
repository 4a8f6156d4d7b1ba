#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/motion_twins.hpp"

namespace lockstep::integrate_velocities_test {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// A body turning freely, its axes along those of the world.
BodySetup rotating_body(Vector3 inertia, Vector3 w) {
  BodySetup body;
  body.inertia = inertia;
  body.angular_velocity = w;
  return body;
}

MotionSetup weightless(double dt, Gyroscopic gyroscopic) {
  return {.dt = dt, .gyroscopic = gyroscopic, .gravities = {{0, 0, 0}}};
}

/// The velocity stage alone, again and again. The body does not turn meanwhile, so that this integrates Euler's
/// equations in the body frame.
template <class real>
Buffers<real> run_velocities(const InitialState<real>& state, u32 times) {
  ReferenceBackend<real> backend(state);
  for (u32 i = 0; i < times; ++i) backend.run(Stage::integrate_velocities, state.params);
  return backend.buffers();
}

TEST(IntegrateVelocities, GravityOfItsOwnWorldPullsEachDynamicBody) {
  std::vector<BodySetup> bodies(4);
  bodies[1].world = bodies[2].world = bodies[3].world = 1;
  bodies[2].kind = BODY_KINEMATIC;
  bodies[2].velocity = {1, 2, 3};
  bodies[3].kind = BODY_STATIC;
  const Buffers<double> after =
      run_velocities(make_bodies<double>(bodies, {.dt = 0.25, .gravities = {{0, 0, -8}, {4, 0, 0}}}), 2);
  EXPECT_EQ(velocity(after, 0), (Vector3{0, 0, -4}));
  EXPECT_EQ(velocity(after, 1), (Vector3{2, 0, 0}));
  EXPECT_EQ(velocity(after, 2), (Vector3{1, 2, 3}));
  EXPECT_EQ(velocity(after, 3), (Vector3{0, 0, 0}));
}

TEST(IntegrateVelocities, RemembersTheVelocitiesItStartedFrom) {
  const InitialState<double> state = make_bodies<double>(mixed_bodies(true), {.gravities = {{0, 0, -1}, {0, 0, -2}}});
  const Buffers<double> after = run_velocities(state, 1);
  for (u32 i = 0; i < state.sizes.bodies; ++i) {
    for (u32 k = 0; k < 3; ++k) {
      EXPECT_EQ(after.previous_velocities[i].v[k], state.buffers.motions[i].v[k]);
      EXPECT_EQ(after.previous_velocities[i].w[k], state.buffers.motions[i].w[k]);
    }
  }
}

TEST(IntegrateVelocities, InverseInertiaRotatesWithTheBody) {
  BodySetup body;
  body.inertia = {1, 2, 2.5};
  body.orientation = about({1, -2, 0.5}, 1.3);
  const Buffers<double> after = run_velocities(make_bodies<double>({body}, {}), 1);
  const Motion<double>& m = after.motions[0];
  // column by column: turn to the body frame, divide by the principal moments, turn back
  const double inverse[3][3] = {{m.inertia_xx, m.inertia_xy, m.inertia_xz},
                                {m.inertia_xy, m.inertia_yy, m.inertia_yz},
                                {m.inertia_xz, m.inertia_yz, m.inertia_zz}};
  for (u32 k = 0; k < 3; ++k) {
    Vector3 axis = {0, 0, 0};
    axis[k] = 1;
    const Vector3 rotated = unrotate(body.orientation, axis);
    const Vector3 expected = rotate(body.orientation, {rotated[0] / 1, rotated[1] / 2, rotated[2] / 2.5});
    for (u32 row = 0; row < 3; ++row) EXPECT_NEAR(inverse[row][k], expected[row], 1e-15);
  }
}

TEST(IntegrateVelocities, InverseInertiaOfASphereIsExactAndOfAnImmovableBodyZero) {
  std::vector<BodySetup> bodies(2);
  bodies[0].inertia = {0.3, 0.3, 0.3};
  bodies[0].orientation = about({1, -2, 0.5}, 1.3);
  bodies[1].kind = BODY_KINEMATIC;
  const Buffers<float> after = run_velocities(make_bodies<float>(bodies, {}), 1);
  const Motion<float>& sphere = after.motions[0];
  EXPECT_EQ(sphere.inertia_xx, float(1 / 0.3));
  EXPECT_EQ(sphere.inertia_yy, sphere.inertia_xx);
  EXPECT_EQ(sphere.inertia_zz, sphere.inertia_xx);
  EXPECT_EQ(sphere.inertia_xy, 0);
  EXPECT_EQ(sphere.inertia_xz, 0);
  EXPECT_EQ(sphere.inertia_yz, 0);
  EXPECT_EQ(after.motions[1].inertia_xx, 0);
  EXPECT_EQ(after.motions[2].inertia_xx, 0) << "the null body";
}

// A symmetric body (I_x = I_y) turns its body-frame (w_x, w_y) at the rate (I_z - I_x) / I_x w_z.
double nutation_error(Gyroscopic gyroscopic, u32 steps) {
  const double end = 2, w_x = 0.7, w_z = 3, rate = (1.8 - 1) / 1 * w_z;
  const BodySetup body = rotating_body({1, 1, 1.8}, {w_x, 0, w_z});
  const auto after = run_velocities(make_bodies<double>({body}, weightless(end / steps, gyroscopic)), steps);
  const Vector3 exact = {w_x * std::cos(rate * end), w_x * std::sin(rate * end), w_z};
  return length(angular_velocity(after, 0) - exact);
}

TEST(IntegrateVelocities, NutationOfASymmetricBodyConverges) {
  // error at two time steps: halving them gains a factor of two per order
  EXPECT_NEAR(nutation_error(Gyroscopic::explicit_, 400) / nutation_error(Gyroscopic::explicit_, 800), 2, 0.1);
  EXPECT_NEAR(nutation_error(Gyroscopic::implicit, 400) / nutation_error(Gyroscopic::implicit, 800), 2, 0.1);
  EXPECT_NEAR(nutation_error(Gyroscopic::midpoint, 400) / nutation_error(Gyroscopic::midpoint, 800), 4, 0.1);
  EXPECT_LT(nutation_error(Gyroscopic::midpoint, 800), 2e-5);
}

TEST(IntegrateVelocities, MidpointKeepsTheEnergyImplicitLosesExplicitGains) {
  const auto growth = [](Gyroscopic gyroscopic) {
    const auto state = make_bodies<double>({rotating_body({1, 2, 3}, {0.5, 5, -1})}, weightless(0.02, gyroscopic));
    return rotation_energy(run_velocities(state, 200), 0) / rotation_energy(state.buffers, 0) - 1;
  };
  EXPECT_NEAR(growth(Gyroscopic::midpoint), 0, 1e-12);
  EXPECT_LT(growth(Gyroscopic::implicit), -0.1);
  EXPECT_GT(growth(Gyroscopic::explicit_), 0.1);
}

TEST(IntegrateVelocities, WithoutTheGyroscopicMomentAngularVelocityStaysConstant) {
  const auto state = make_bodies<double>({rotating_body({1, 2, 3}, {0.5, 5, -1})}, weightless(0.02, Gyroscopic::none));
  EXPECT_EQ(angular_velocity(run_velocities(state, 100), 0), (Vector3{0.5, 5, -1}));
}

// Random shapes from needles to plates, random spins, from a tenth of a radian a step to far too many.
template <class real>
void expect_energy_never_grows(Gyroscopic gyroscopic, double rounding) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<BodySetup> bodies(500);
  for (u32 i = 0; i < bodies.size(); ++i) {
    const double a = std::pow(10, 3 * uniform(random)), b = std::pow(10, 3 * uniform(random));
    const Vector3 w = {uniform(random), uniform(random), uniform(random)};
    const double speed = std::pow(10, -1 + 0.007 * i);  // rad a step, up to 300
    bodies[i] = rotating_body({1 + a, 1 + b, a + b}, (speed / length(w)) * w);
  }
  const auto state = make_bodies<real>(bodies, weightless(1, gyroscopic));
  ReferenceBackend<real> backend(state);
  Buffers<real> before = state.buffers;
  for (u32 round = 0; round < 20; ++round) {
    backend.run(Stage::integrate_velocities, state.params);
    const Buffers<real>& after = backend.buffers();
    for (u32 i = 0; i < bodies.size(); ++i) {
      ASSERT_LE(rotation_energy(after, i), rotation_energy(before, i) * (1 + rounding)) << "body " << i;
    }
    before = after;
  }
  EXPECT_EQ(before.counters[COUNTER_STATUS], 0u);
}

TEST(IntegrateVelocities, EnergyNeverGrowsHoweverLargeTheAngularVelocity) {
  expect_energy_never_grows<double>(Gyroscopic::implicit, 1e-12);
  expect_energy_never_grows<double>(Gyroscopic::midpoint, 1e-12);
  expect_energy_never_grows<float>(Gyroscopic::implicit, 1e-4);
  expect_energy_never_grows<float>(Gyroscopic::midpoint, 1e-4);
}

TEST(IntegrateVelocities, GravityRotatesABodyAboutItsPivot) {
  // a rod of 2 kg hangs level, 0.5 m from its pivot: w_dot = m g l / I about the pivot
  BodySetup rod;
  rod.mass = 2;
  rod.pivoted = true;
  rod.com_offset = {0, 0, 0.5};
  rod.inertia = {0.8, 0.8, 0.1};
  rod.orientation = about({0, 1, 0}, std::acos(-1) / 2);  // com_offset along x
  rod.position = {0.5, 0, 0};
  for (const Gyroscopic gyroscopic : {Gyroscopic::none, Gyroscopic::implicit}) {
    const auto state = make_bodies<double>({rod}, {.dt = 0.125, .gyroscopic = gyroscopic, .gravities = {{0, 0, -10}}});
    const Buffers<double> after = run_velocities(state, 1);
    const double expected = 0.125 * 2 * 10 * 0.5 / 0.8;
    EXPECT_NEAR(length(angular_velocity(after, 0) - Vector3{0, expected, 0}), 0, 1e-15);
    EXPECT_NEAR(length(velocity(after, 0) - Vector3{0, 0, -0.5 * expected}), 0, 1e-15);
  }
}

TEST(IntegrateVelocities, AForceAndATorqueFromOutsideAct) {
  std::vector<BodySetup> bodies(4);
  bodies[1].mass = 4, bodies[1].force = {8, 0, 0};
  bodies[2].inertia = {2, 4, 8}, bodies[2].torque = {4, 4, 4};
  bodies[2].orientation = about({0, 0, 1}, std::acos(-1) / 2);  // its axis x along y of the world
  bodies[3].kind = BODY_KINEMATIC, bodies[3].force = {1, 1, 1}, bodies[3].torque = {1, 1, 1};
  for (const Gyroscopic gyroscopic : {Gyroscopic::none, Gyroscopic::explicit_}) {  // from rest they are one
    const auto state = make_bodies<double>(bodies, {.dt = 0.5, .gyroscopic = gyroscopic, .gravities = {{0, 0, -2}}});
    const Buffers<double> after = run_velocities(state, 1);
    EXPECT_EQ(velocity(after, 0), (Vector3{0, 0, -1}));
    EXPECT_EQ(velocity(after, 1), (Vector3{1, 0, -1}));
    EXPECT_NEAR(length(angular_velocity(after, 2) - Vector3{0.5, 1, 0.25}), 0, 1e-15);
    EXPECT_EQ(length(velocity(after, 3)) + length(angular_velocity(after, 3)), 0);
  }
}

// The moment of a force at the centre of mass of a rod on a pivot is com_offset x force, as that of gravity is.
TEST(IntegrateVelocities, AForceRotatesABodyAboutItsPivot) {
  BodySetup rod;
  rod.mass = 2;
  rod.pivoted = true;
  rod.com_offset = {0, 0, 0.5};
  rod.inertia = {0.8, 0.8, 0.1};
  rod.orientation = about({0, 1, 0}, std::acos(-1) / 2);
  rod.position = {0.5, 0, 0};
  const auto under_gravity = make_bodies<double>({rod}, {.dt = 0.125, .gravities = {{0, 0, -10}}});
  rod.force = {0, 0, -20};
  const auto under_force = make_bodies<double>({rod}, {.dt = 0.125, .gravities = {{0, 0, 0}}});
  EXPECT_NEAR(length(angular_velocity(run_velocities(under_gravity, 1), 0) -
                     angular_velocity(run_velocities(under_force, 1), 0)),
              0, 1e-15);
}

TEST(IntegrateVelocities, NamesTheFirstBodyThatWentBad) {
  for (const double bad : {not_a_number, infinity, -infinity, 1e6, 1e30}) {
    std::vector<BodySetup> bodies(5);
    bodies[2].velocity = {0, bad, 0};
    bodies[4].velocity = {bad, 0, 0};
    const Buffers<float> after = run_velocities(make_bodies<float>(bodies, {}), 1);
    EXPECT_EQ(after.counters[COUNTER_STATUS], u32{STATUS_BAD_FORCES}) << bad;
    EXPECT_EQ(NONE - after.counters[COUNTER_BAD_BODY], 2u) << bad;
  }
  for (const double bad : {not_a_number, infinity}) {
    std::vector<BodySetup> bodies(3);
    bodies[1].angular_velocity = {0, 0, bad};
    const Buffers<float> after = run_velocities(make_bodies<float>(bodies, {}), 1);
    EXPECT_EQ(after.counters[COUNTER_STATUS], u32{STATUS_BAD_FORCES}) << bad;
    EXPECT_EQ(NONE - after.counters[COUNTER_BAD_BODY], 1u) << bad;
  }
}

TEST(IntegrateVelocities, FastButGoodIsNotBad) {
  std::vector<BodySetup> bodies(2);
  bodies[0].velocity = {0, 0.99e5, 0};
  bodies[1].angular_velocity = {1e6, 0, 0};
  EXPECT_EQ(run_velocities(make_bodies<float>(bodies, {}), 1).counters[COUNTER_STATUS], 0u);
}

TEST(IntegrateVelocities, LeavesAnAbortedStepAlone) {
  InitialState<double> state = make_bodies<double>(mixed_bodies(false), {.gravities = {{0, 0, -1}, {0, 0, -2}}});
  state.buffers.counters[COUNTER_STATUS] = STATUS_CONTACTS_FULL;
  const Buffers<double> after = run_velocities(state, 1);
  for (u32 i = 0; i < state.sizes.bodies; ++i) EXPECT_EQ(velocity(after, i), velocity(state.buffers, i));
}

TEST(IntegrateVelocities, KernelMatchesReference) {
  expect_motion_twins_agree<float>(Stage::integrate_velocities,
                                   {Integrator::semi_implicit_euler, Integrator::trapezoidal});
  expect_motion_twins_agree<double>(Stage::integrate_velocities,
                                    {Integrator::semi_implicit_euler, Integrator::trapezoidal});
}

}  // namespace
}  // namespace lockstep::integrate_velocities_test
