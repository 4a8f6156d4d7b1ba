// What is solved along a gradient, in closed form: rest, weight, friction, and the lift that the convex relaxation
// gives what slides.
#include <gtest/gtest.h>

#include "host/scene/read.hpp"
#include "tests/gradient_scene.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::gradient_physics_test {
namespace {

constexpr double g = 9.81;

template <class real>
class GradientPhysics : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(GradientPhysics, Precisions);

TYPED_TEST(GradientPhysics, AColumnOfBallsBearsItsWeight) {
  using real = TypeParam;
  InitialState<real> state = column_of_balls<real>(6);
  use_gradient(state, true, 500);
  expect_column_bears_its_weight(run_steps(state, 1), 6, sizeof(real) == 4 ? 1e-4 : 1e-9);
}

// Two balls of different mass in a row: momentum, and the relative velocity times -e.
TYPED_TEST(GradientPhysics, ImpactOfTwoBalls) {
  using real = TypeParam;
  InitialState<real> state = balls_that_bounce<real>();
  use_gradient(state, true, 200);
  expect_they_bounced(run_steps(state, 1), sizeof(real) == 4 ? 1e-5 : 1e-12);
}

// A box set down sliding is thrown up (tests/oracle/model_error_test.cpp): with friction exact and u_n = mu u_t in one
// step, u_t = (v - mu g dt) / (1 + mu^2).
TEST(GradientPhysicsInDouble, WhatIsSetDownSlidingIsThrownUp) {
  InitialState<double> state =
      make_worlds<double>({{plane_body(), box_body({0, 0, 0.1}, {0.3, 0.3, 0.1}, {0, 0, 0, 1})}}, 16);
  state.buffers.motions[1].v[0] = 3;
  state.params.theta = 1;
  state.params.dt = 1e-3;
  set_material(state, 0.5, 0);
  use_gradient(state, true, 2000);
  const Buffers<double> after = run_steps(state, 1);
  const double along = (3 - 0.5 * g * 1e-3) / 1.25;
  EXPECT_NEAR(after.motions[1].v[0], along, 1e-9);
  EXPECT_NEAR(after.motions[1].v[2], 0.5 * along, 1e-9);
}

// A block of 1 kg on a slope; x down the slope, z off it.
struct OnSlope {
  double angle, friction, dt = 1.0 / 60;
  InitialState<double> state;

  OnSlope(double slope_angle, double mu, u32 iterations) : angle(slope_angle), friction(mu) {
    const Quaternion rotation = {0, std::sin(angle / 2), 0, std::cos(angle / 2)};
    const double height = 0.1;
    BodyDescription block =
        box_body({height * std::sin(angle), 0, height * std::cos(angle)}, {0.4, 0.3, height}, rotation);
    state = make_worlds<double>({{plane_body({0, 0, 0}, rotation), block}}, 16);
    state.params.theta = 1;
    state.params.dt = dt;
    state.params.slop = 0;
    state.params.margin = 0.1;
    set_material(state, friction, 0);
    use_gradient(state, true, iterations);
  }
  double along(const Buffers<double>& b) const {
    return b.motions[1].v[0] * std::cos(angle) - b.motions[1].v[2] * std::sin(angle);
  }
  double off(const Buffers<double>& b) const {
    return b.positions[1].x * std::sin(angle) + b.positions[1].z * std::cos(angle) - 0.1;
  }
};

TEST(GradientSlope, BelowTheLimitOfFrictionItSticks) {
  const OnSlope slope(0.4, 0.5, 2000);  // tan 0.4 = 0.42
  const Buffers<double> after = run_steps(slope.state, 30);
  EXPECT_NEAR(slope.along(after), 0, 1e-9);
  EXPECT_NEAR(slope.off(after), 0, 1e-9);
}

// u_n + gap / dt >= mu |u_t|, with equality where it presses: the block flies at a height mu |u_t| dt. Friction itself
// is exact, mu times what presses; but what presses also lifts the block while that gets faster. With d the change of
// speed in a step, v_n' = mu d and r_n = m (g cos dt + v_n' - v_n),
//   d' (1 + mu^2) = a dt + mu^2 d,   a = g (sin - mu cos),
// which is Coulomb's a from a few steps on.
TEST(GradientSlope, WhatSlidesLiftsByMuTimesItsSpeed) {
  const double mu = 0.2;
  const OnSlope slope(0.5, mu, 3000);
  const double a = g * (std::sin(0.5) - mu * std::cos(0.5));
  ReferenceBackend<double> backend(slope.state);
  double speed = 0, change = 0;
  for (u32 i = 1; i <= 60; ++i) {
    step(backend, slope.state.params);
    const Buffers<double>& current = backend.buffers();
    ASSERT_GT(current.counters[COUNTER_CONTACTS], 0u) << i;
    change = (a * slope.dt + mu * mu * change) / (1 + mu * mu);
    speed += change;
    EXPECT_NEAR(slope.along(current), speed, 1e-7) << i;
    EXPECT_NEAR(slope.off(current), mu * speed * slope.dt, 1e-7) << i;
  }
  EXPECT_NEAR(change / slope.dt, a, 1e-9);
  EXPECT_GT(slope.off(backend.buffers()), 5e-3);
}

// The residual of the report is that of the convex problem; the model error says what Coulomb's law would.
TEST(GradientSlope, TheReportTellsSolvingFromModelling) {
  const OnSlope slides(0.5, 0.2, 3000), sticks(0.4, 0.5, 3000);
  const Residual sliding = residual_of(run_steps(slides.state, 10)),
                 sticking = residual_of(run_steps(sticks.state, 10));
  EXPECT_LT(sliding.relative, 1e-8);
  EXPECT_LT(sticking.relative, 1e-8);
  ASSERT_TRUE(sliding.model_error && sticking.model_error);
  EXPECT_GT(*sliding.model_error, 0.1);
  EXPECT_NEAR(*sticking.model_error, 0, 1e-8);
}

// ---- joints ---------------------------------------------------------------------------------------------------------

// Each ball joint of a chain at rest carries what hangs from it.
TYPED_TEST(GradientPhysics, AChainCarriesItsWeight) {
  using real = TypeParam;
  const u32 links = 10;
  const double dt = 1.0 / 240;
  std::vector<BodyDescription> bodies;
  std::vector<JointDescription> joints;
  for (u32 i = 0; i < links; ++i) {
    bodies.push_back(bare_body({0, 0, -0.5 - i}));
    joints.push_back(joint_of(JOINT_BALL, i == 0 ? NONE : i - 1, i, {0, 0, -double(i)}));
  }
  Scene scene = joint_scene(bodies, joints, dt);
  replace_solver(scene.settings, Solver::accelerated_gradient);
  scene.settings.iterations = 2000;
  const InitialState<real> state = compile<real>(scene);
  ASSERT_TRUE(has(state.features, Feature::gradient));
  ASSERT_FALSE(has(state.features, Feature::jacobi));
  const Buffers<real> after = run_steps(state, 1);
  for (u32 block = 0; block < state.sizes.joint_blocks; ++block) {
    for (u32 lane = 0; lane < PACK; ++lane) {
      const u32 joint = after.joint_lanes[block].joint[lane];
      if (joint == NONE) continue;
      const real* r[] = {after.joint_impulses[block].locked[0], after.joint_impulses[block].locked[1],
                         after.joint_impulses[block].locked[2]};
      const double size = std::hypot(double(r[0][lane]), double(r[1][lane]), double(r[2][lane]));
      EXPECT_NEAR(size, (links - joint) * g * dt, sizeof(real) == 4 ? 2e-4 : 1e-9) << joint;
    }
  }
  for (u32 i = 0; i < links; ++i) EXPECT_NEAR(double(after.motions[i].v[2]), 0, sizeof(real) == 4 ? 1e-4 : 1e-9) << i;
}

// Motors, limits, springs, screws and dry friction have the same laws by both solvers, and joints alone have one
// answer.
TEST(GradientJoints, EndWhereGaussSeidelDoes) {
  for (const char* name : {"governor", "pendulum_chain", "screw_nut", "cardan_shaft", "slider_crank"}) {
    SCOPED_TRACE(name);
    Scene scene = read_scene(name);
    const auto after = [&](Solver solver, u32 iterations) {
      replace_solver(scene.settings, solver);
      scene.settings.iterations = iterations;
      return run_steps(compile<double>(scene), 2);
    };
    const Buffers<double> sweeps = after(Solver::gauss_seidel, 20000),
                          descent = after(Solver::accelerated_gradient, 20000);
    expect_same_velocities(descent, sweeps);
  }
}

TYPED_TEST(GradientPhysics, JointsMatchTheReference) {
  using real = TypeParam;
  for (const char* name : {"rag_doll", "rover", "governor"}) {
    SCOPED_TRACE(name);
    Scene scene = read_scene(name);
    replace_solver(scene.settings, Solver::accelerated_gradient);
    scene.settings.iterations = 15;
    scene.settings.tolerance = 0;
    expect_twins_agree(compile<real>(scene), 30, launch_options({{16, 7}, {1, 0}}));
    scene.settings.tolerance = 0.01;
    expect_twins_agree(compile<real>(scene), 10, launch_options({{16, 7}}));
  }
}

}  // namespace
}  // namespace lockstep::test::gradient_physics_test
