#include <gtest/gtest.h>

#include <limits>

#include "tests/closed_forms.hpp"
#include "tests/motion_twins.hpp"

namespace lockstep::integrate_positions_test {
namespace {

Vector3 fallen_after(Integrator integrator, double end, u32 steps) {
  BodySetup ball;
  ball.position = {1, 2, 10};
  ball.velocity = {3, 0, 4};
  return position(run_steps(make_bodies<double>({ball}, {.dt = end / steps, .integrator = integrator}), steps), 0);
}

TEST(IntegratePositions, ParabolaIsExactOrFirstOrder) {
  const double end = 1.5;
  const Vector3 exact = {1 + 3 * end, 2, 10 + 4 * end - 0.5 * 9.81 * end * end};
  EXPECT_LT(length(fallen_after(Integrator::trapezoidal, end, 30) - exact), 1e-13);
  EXPECT_LT(length(fallen_after(Integrator::trapezoidal, end, 60) - exact), 1e-13);
  // the Euler schemes miss by g t dt / 2, on either side
  for (const u32 steps : {30u, 60u}) {
    const double miss = 0.5 * 9.81 * end * (end / steps);
    EXPECT_NEAR(fallen_after(Integrator::semi_implicit_euler, end, steps)[2], exact[2] - miss, 1e-12);
    EXPECT_NEAR(fallen_after(Integrator::explicit_euler, end, steps)[2], exact[2] + miss, 1e-12);
  }
}

TEST(IntegratePositions, EulerSchemesMoveWithOneVelocityExactly) {
  BodySetup ball;
  ball.position = {0.1, 0.2, 0.3};
  for (const Integrator integrator : {Integrator::explicit_euler, Integrator::semi_implicit_euler}) {
    InitialState<float> state = make_bodies<float>({ball}, {.dt = 1.0 / 60, .integrator = integrator});
    state.buffers.previous_velocities[0] = {{0.7f, -0.3f, 1e-3f}, 0, {0, 0, 0}, 0};
    state.buffers.motions[0].v[0] = 0.9f;
    const float v = integrator == Integrator::explicit_euler ? 0.7f : 0.9f;
    EXPECT_EQ(run_stage(Stage::integrate_positions, state).positions[0].x, 0.1f + state.params.dt * v);
  }
}

TEST(IntegratePositions, AConstantAngularVelocityRotatesByItsAngle) {
  BodySetup ball;
  ball.angular_velocity = {0, 0, 2};
  const double dt = 0.3;
  const auto after = run_steps(make_bodies<double>({ball}, {.dt = dt, .gravities = {{0, 0, 0}}}), 4);
  const Quaternion q = orientation(after, 0), exact = about({0, 0, 1}, 4 * 2 * dt);
  EXPECT_NEAR(q[2], exact[2], 1e-15);
  EXPECT_NEAR(q[3], exact[3], 1e-15);
}

TEST(IntegratePositions, KinematicBodiesKeepTheirVelocityAndStaticOnesTheirPose) {
  std::vector<BodySetup> bodies(2);
  bodies[0].kind = BODY_KINEMATIC;
  bodies[0].velocity = {1, 0, -2};
  bodies[0].angular_velocity = {0, 0.5, 0};
  bodies[1].kind = BODY_STATIC;
  bodies[1].position = {7, 8, 9};
  for (const Integrator integrator :
       {Integrator::explicit_euler, Integrator::semi_implicit_euler, Integrator::trapezoidal}) {
    const auto after = run_steps(make_bodies<double>(bodies, {.dt = 0.25, .integrator = integrator}), 8);
    EXPECT_EQ(position(after, 0), (Vector3{2, 0, -4}));
    EXPECT_EQ(velocity(after, 0), (Vector3{1, 0, -2}));
    EXPECT_NEAR(orientation(after, 0)[1], std::sin(8 * 0.0625), 1e-15);
    EXPECT_EQ(position(after, 1), (Vector3{7, 8, 9}));
    EXPECT_EQ(orientation(after, 1), (Quaternion{0, 0, 0, 1}));
  }
}

TEST(IntegratePositions, MidpointConservesEnergyAndAngularMomentumOfAFreeBody) {
  BodySetup body = dzhanibekov(0.1);
  body.orientation = about({1, 2, 3}, 0.7);
  body.angular_velocity = rotate(body.orientation, body.angular_velocity);
  const auto state =
      make_bodies<double>({body}, {.dt = 0.02, .integrator = Integrator::trapezoidal, .gravities = {{0, 0, -9.81}}});
  const Buffers<double> after = run_steps(state, 5000);
  const Vector3 before = angular_momentum(state.buffers, 0);
  EXPECT_LT(length(angular_momentum(after, 0) - before) / length(before), 1e-12);
  EXPECT_NEAR(rotation_energy(after, 0) / rotation_energy(state.buffers, 0), 1, 1e-12);
}

TEST(IntegratePositions, DzhanibekovConvergesAtSecondOrder) {
  for (const double epsilon : {0.01, 0.1}) {
    const double coarse = dzhanibekov_error(epsilon, Integrator::trapezoidal, 1000);
    const double fine = dzhanibekov_error(epsilon, Integrator::trapezoidal, 2000);
    EXPECT_NEAR(coarse / fine, 4, 0.1) << epsilon;
    EXPECT_LT(fine, 1e-5) << epsilon;
  }
  const MotionSetup motion = {.dt = 1e-3, .integrator = Integrator::trapezoidal};
  EXPECT_NEAR(measured_dzhanibekov_period(1e-3, motion), 13.722675, 5e-5);
}

TEST(IntegratePositions, OrientationsOfAFreeBodyConvergeByTheOrderOfTheScheme) {
  const Vector3 exact = dzhanibekov_axis_after(Integrator::runge_kutta, 4000);
  const auto gain = [&](Integrator integrator) {
    return length(dzhanibekov_axis_after(integrator, 1000) - exact) /
           length(dzhanibekov_axis_after(integrator, 2000) - exact);
  };
  // a free body turns by the mean angular velocity, whatever the integrator says of forces
  EXPECT_NEAR(gain(Integrator::trapezoidal), 4, 0.1);
  EXPECT_NEAR(gain(Integrator::semi_implicit_euler), 4, 0.1);
  EXPECT_NEAR(gain(Integrator::explicit_euler), 4, 0.1);
}

TEST(IntegratePositions, PendulumConvergesToTheClosedForm) {
  // released level, it has no error of second order over a swing: what the Cayley map missed was all of it
  EXPECT_GT(pendulum_error(Integrator::trapezoidal, 1000) / pendulum_error(Integrator::trapezoidal, 2000), 15);
  EXPECT_LT(pendulum_error(Integrator::trapezoidal, 8000), 1e-9);
  const auto gain = [](Integrator integrator) {
    return pendulum_error(integrator, 32000) / pendulum_error(integrator, 64000);
  };
  EXPECT_NEAR(gain(Integrator::semi_implicit_euler), 2, 0.1);
  EXPECT_NEAR(gain(Integrator::explicit_euler), 2, 0.1);
}

TEST(IntegratePositions, HeavyTopConvergesAtSecondOrderAndKeepsItsEnergy) {
  const Vector3 exact = top_axis_after(Integrator::runge_kutta, 4000);
  const double coarse = length(top_axis_after(Integrator::trapezoidal, 1000) - exact);
  const double fine = length(top_axis_after(Integrator::trapezoidal, 2000) - exact);
  EXPECT_NEAR(coarse / fine, 4, 0.1);
  EXPECT_LT(top_energy_drift(Integrator::trapezoidal), 1e-5);
  EXPECT_LT(top_energy_drift(Integrator::semi_implicit_euler), 1e-5);
}

TEST(IntegratePositions, SteadyPrecessionConvergesAtSecondOrder) {
  for (const double rate : {0.848689, 22.245322}) {
    const double coarse = measured_precession(rate, Integrator::trapezoidal, 0.002, 2).rate - rate;
    const double fine = measured_precession(rate, Integrator::trapezoidal, 0.001, 2).rate - rate;
    EXPECT_NEAR(coarse / fine, 4, 0.1) << rate;
    EXPECT_LT(std::fabs(fine), 1.2e-3 * rate) << rate;
  }
}

TEST(IntegratePositions, APivotedBodyStaysOnItsPivot) {
  const auto state = make_bodies<float>(mixed_bodies(true), {.gravities = {{0, 0, -9.81}, {0, 0, -3}}});
  const Buffers<float> after = run_steps(state, 100);
  for (u32 i = 5; i < 8; ++i) {
    const Vector3 com_offset = rotate(
        orientation(after, i),
        {after.pivots[i].com_offset_body[0], after.pivots[i].com_offset_body[1], after.pivots[i].com_offset_body[2]});
    const Vector3 pivot = {after.pivots[i].point_world[0], after.pivots[i].point_world[1],
                           after.pivots[i].point_world[2]};
    EXPECT_LT(length(position(after, i) - pivot - com_offset), 2e-6) << i;
    EXPECT_LT(length(velocity(after, i) - cross(angular_velocity(after, i), com_offset)), 2e-5) << i;
  }
}

TEST(IntegratePositions, NamesTheFirstBodyThatWentBad) {
  const float bad = std::numeric_limits<float>::quiet_NaN();
  InitialState<float> state = make_bodies<float>(std::vector<BodySetup>(4), {});
  state.buffers.motions[3].v[1] = bad;
  state.buffers.motions[2].w[1] = bad;
  Buffers<float> after = run_stage(Stage::integrate_positions, state);
  EXPECT_EQ(after.counters[COUNTER_STATUS], u32{STATUS_BAD_CONTACTS} | u32{STATUS_BAD_POSE});
  EXPECT_EQ(NONE - after.counters[COUNTER_BAD_BODY], 2u);

  state = make_bodies<float>(std::vector<BodySetup>(4), {});
  state.buffers.positions[1].z = bad;
  after = run_stage(Stage::integrate_positions, state);
  EXPECT_EQ(after.counters[COUNTER_STATUS], u32{STATUS_BAD_POSE});
  EXPECT_EQ(NONE - after.counters[COUNTER_BAD_BODY], 1u);
}

TEST(IntegratePositions, LeavesAnAbortedStepAlone) {
  BodySetup ball;
  ball.velocity = {1, 1, 1};
  InitialState<double> state = make_bodies<double>({ball}, {});
  state.buffers.counters[COUNTER_STATUS] = STATUS_BLOCKS_FULL;
  EXPECT_EQ(position(run_stage(Stage::integrate_positions, state), 0), (Vector3{0, 0, 0}));
}

TEST(IntegratePositions, KernelMatchesReference) {
  expect_motion_twins_agree<float>(
      Stage::integrate_positions,
      {Integrator::explicit_euler, Integrator::semi_implicit_euler, Integrator::trapezoidal});
  expect_motion_twins_agree<double>(
      Stage::integrate_positions,
      {Integrator::explicit_euler, Integrator::semi_implicit_euler, Integrator::trapezoidal});
}

}  // namespace
}  // namespace lockstep::integrate_positions_test
