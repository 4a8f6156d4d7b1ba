#include <gtest/gtest.h>

#include <limits>

#include "tests/closed_forms.hpp"
#include "tests/motion_twins.hpp"

namespace lockstep::integrate_free_flight_test {
namespace {

constexpr Integrator runge_kutta = Integrator::runge_kutta;

TEST(IntegrateFreeFlight, ParabolaIsExactAtEveryStep) {
  BodySetup ball;
  ball.position = {1, 2, 10};
  ball.velocity = {3, 0, 4};
  const double end = 1.5;
  for (const u32 steps : {1u, 30u, 60u}) {
    const auto after = run_steps(make_bodies<double>({ball}, {.dt = end / steps, .integrator = runge_kutta}), steps);
    const Vector3 exact = {1 + 3 * end, 2, 10 + 4 * end - 0.5 * 9.81 * end * end};
    EXPECT_LT(length(position(after, 0) - exact), 1e-13);
    EXPECT_LT(length(velocity(after, 0) - Vector3{3, 0, 4 - 9.81 * end}), 1e-13);
  }
}

TEST(IntegrateFreeFlight, KinematicBodiesKeepTheirVelocityAndStaticOnesTheirPose) {
  std::vector<BodySetup> bodies(2);
  bodies[0].kind = BODY_KINEMATIC;
  bodies[0].velocity = {1, 0, -2};
  bodies[0].angular_velocity = {0, 0.5, 0};
  bodies[1].kind = BODY_STATIC;
  bodies[1].position = {7, 8, 9};
  const auto after = run_steps(make_bodies<double>(bodies, {.dt = 0.25, .integrator = runge_kutta}), 8);
  EXPECT_EQ(position(after, 0), (Vector3{2, 0, -4}));
  EXPECT_EQ(velocity(after, 0), (Vector3{1, 0, -2}));
  EXPECT_EQ(angular_velocity(after, 0), (Vector3{0, 0.5, 0}));
  EXPECT_NEAR(orientation(after, 0)[1], std::sin(0.5), 1e-7);
  EXPECT_EQ(position(after, 1), (Vector3{7, 8, 9}));
  EXPECT_EQ(orientation(after, 1), (Quaternion{0, 0, 0, 1}));
}

TEST(IntegrateFreeFlight, DzhanibekovHasItsPeriod) {
  EXPECT_NEAR(dzhanibekov_period(1e-3), 13.722675, 1e-6);  // the closed form, against the published figures
  EXPECT_NEAR(dzhanibekov_period(0.01), 10.532110, 1e-6);
  EXPECT_NEAR(dzhanibekov_period(0.1), 7.340968, 1e-6);
  for (const double epsilon : {1e-3, 0.01, 0.1}) {
    const MotionSetup motion = {.dt = 0.01, .integrator = runge_kutta, .gravities = {{0, 0, 0}}};
    EXPECT_NEAR(measured_dzhanibekov_period(epsilon, motion), dzhanibekov_period(epsilon), 1e-6) << epsilon;
    // a flip is symmetric, which gains an order
    const double coarse = dzhanibekov_error(epsilon, runge_kutta, 125);
    const double fine = dzhanibekov_error(epsilon, runge_kutta, 250);
    EXPECT_GT(coarse / fine, 15) << epsilon;
    EXPECT_LT(fine, 1e-6) << epsilon;
  }
}

TEST(IntegrateFreeFlight, AFreeBodyConvergesAtFourthOrderAndKeepsItsInvariants) {
  const Vector3 exact = dzhanibekov_axis_after(runge_kutta, 3200);
  const double coarse = length(dzhanibekov_axis_after(runge_kutta, 100) - exact);
  const double fine = length(dzhanibekov_axis_after(runge_kutta, 200) - exact);
  EXPECT_NEAR(coarse / fine, 16, 2);

  const auto state = make_bodies<double>({dzhanibekov(0.1)}, {.dt = 0.002, .integrator = runge_kutta});
  const Buffers<double> after = run_steps(state, 5000);
  EXPECT_NEAR(rotation_energy(after, 0) / rotation_energy(state.buffers, 0), 1, 1e-10);
  EXPECT_LT(length(angular_momentum(after, 0) - angular_momentum(state.buffers, 0)), 2e-9);
}

TEST(IntegrateFreeFlight, PendulumConvergesAtFourthOrderToTheClosedForm) {
  EXPECT_NEAR(pendulum_error(runge_kutta, 2000) / pendulum_error(runge_kutta, 4000), 16, 2);
  EXPECT_LT(pendulum_error(runge_kutta, 2000), 2e-8);
}

TEST(IntegrateFreeFlight, HeavyTopKeepsItsEnergyAndConvergesAtFourthOrder) {
  EXPECT_NEAR(top_energy(make_bodies<double>({simo_wong_top()}, {}).buffers), 1269.975005, 1e-6);
  EXPECT_LT(top_energy_drift(runge_kutta), 1e-5);  // the yardstick is 1e-3
  const Vector3 exact = top_axis_after(runge_kutta, 8000);
  EXPECT_NEAR(length(top_axis_after(runge_kutta, 500) - exact) / length(top_axis_after(runge_kutta, 1000) - exact), 16,
              1);
}

TEST(IntegrateFreeFlight, PrecessionIsSteadyAtItsTwoRates) {
  for (const double rate : {0.848689, 22.245322}) {
    const Precession precession = measured_precession(rate, runge_kutta, 0.001, 2);
    EXPECT_NEAR(precession.rate, rate, 1e-6) << rate;
    EXPECT_LT(precession.nutation, 1e-7) << rate;
  }
  EXPECT_GT(measured_precession(5, runge_kutta, 0.001, 2).nutation, 0.01) << "another rate is no steady one";
}

TEST(IntegrateFreeFlight, FloatFollowsDouble) {
  const auto end = [](auto precision) {
    using real = decltype(precision);
    return position(run_steps(make_bodies<real>({pendulum()}, {.dt = 0.01, .integrator = runge_kutta}), 1000), 0);
  };
  EXPECT_LT(length(end(0.0f) - end(0.0)), 1e-4);
}

TEST(IntegrateFreeFlight, LeavesALineWithTheInertiaOfItsPose) {
  BodySetup body = dzhanibekov(0.1);
  InitialState<double> state = make_bodies<double>({body}, {.dt = 0.02, .integrator = runge_kutta});
  const Buffers<double> after = run_steps(state, 10);
  const Motion<double>& m = after.motions[0];
  const Vector3 momentum = angular_momentum(after, 0), w = angular_velocity(after, 0);
  EXPECT_NEAR(m.inertia_xx * momentum[0] + m.inertia_xy * momentum[1] + m.inertia_xz * momentum[2], w[0], 1e-14);
  EXPECT_NEAR(m.inertia_xy * momentum[0] + m.inertia_yy * momentum[1] + m.inertia_yz * momentum[2], w[1], 1e-14);
  EXPECT_NEAR(m.inertia_xz * momentum[0] + m.inertia_yz * momentum[1] + m.inertia_zz * momentum[2], w[2], 1e-14);
}

TEST(IntegrateFreeFlight, NamesTheFirstBodyThatWentBad) {
  const float bad = std::numeric_limits<float>::infinity();
  InitialState<float> state = make_bodies<float>(std::vector<BodySetup>(4), {.integrator = runge_kutta});
  state.buffers.motions[3].v[1] = bad;
  state.buffers.motions[2].w[1] = bad;
  Buffers<float> after = run_stage(Stage::integrate_free_flight, state);
  EXPECT_EQ(after.counters[COUNTER_STATUS], u32{STATUS_BAD_FLIGHT} | u32{STATUS_BAD_POSE});
  EXPECT_EQ(NONE - after.counters[COUNTER_BAD_BODY], 2u);

  state = make_bodies<float>(std::vector<BodySetup>(4), {.integrator = runge_kutta});
  state.buffers.orientations[1].w = bad;
  after = run_stage(Stage::integrate_free_flight, state);
  EXPECT_EQ(after.counters[COUNTER_STATUS], u32{STATUS_BAD_POSE});
  EXPECT_EQ(NONE - after.counters[COUNTER_BAD_BODY], 1u);
}

TEST(IntegrateFreeFlight, KernelMatchesReference) {
  expect_motion_twins_agree<float>(Stage::integrate_free_flight, {Integrator::runge_kutta});
  expect_motion_twins_agree<double>(Stage::integrate_free_flight, {Integrator::runge_kutta});
}

}  // namespace
}  // namespace lockstep::integrate_free_flight_test
