// What the dense matrix solves, in closed form: weight, momentum, friction, impacts, and where its sweeps converge to.
#include <gtest/gtest.h>

#include "host/scene/read.hpp"
#include "tests/dense_scene.hpp"

namespace lockstep::test::dense_physics_test {
namespace {

constexpr double g = 9.81;

template <class real>
class DensePhysics : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(DensePhysics, Precisions);

TYPED_TEST(DensePhysics, AColumnOfBallsBearsItsWeight) {
  using real = TypeParam;
  InitialState<real> state = column_of_balls<real>(6);
  use_dense(state, 400);
  expect_column_bears_its_weight(run_steps(state, 1), 6, sizeof(real) == 4 ? 1e-5 : 1e-12);
}

// What changes of impulses give the bodies adds up.
TYPED_TEST(DensePhysics, ConservesMomentum) {
  using real = TypeParam;
  InitialState<real> state = balls_that_collide<real>();
  use_dense(state);
  run_until_prepared(state);
  expect_solving_keeps_momentum(state, sizeof(real) == 4 ? 1e-4 : 2e-13);
}

// Two balls of different mass in a row: momentum, and the relative velocity times -e.
TYPED_TEST(DensePhysics, ImpactOfTwoBalls) {
  using real = TypeParam;
  InitialState<real> state = balls_that_bounce<real>();
  use_dense(state, 1);
  expect_they_bounced(run_steps(state, 1), sizeof(real) == 4 ? 1e-6 : 1e-14);
}

// A block of 1 kg on a slope after `steps` steps: its speed down it.
double speed_on_slope(double angle, double friction, int steps) {
  const Quaternion rotation = {0, std::sin(angle / 2), 0, std::cos(angle / 2)};
  const double height = 0.1;
  const BodyDescription block =
      box_body({height * std::sin(angle), 0, height * std::cos(angle)}, {0.4, 0.3, height}, rotation);
  InitialState<double> state = make_worlds<double>({{plane_body({0, 0, 0}, rotation), block}}, 16);
  state.params.theta = 1;
  state.params.slop = 0;
  set_material(state, friction, 0);
  use_dense(state, 2000);
  const Buffers<double> after = run_steps(state, steps);
  EXPECT_NEAR(after.positions[1].x * std::sin(angle) + after.positions[1].z * std::cos(angle), height, 1e-9);
  return after.motions[1].v[0] * std::cos(angle) - after.motions[1].v[2] * std::sin(angle);
}

// tan 0.4 = 0.42: what friction of 0.5 holds sticks, and what slides at 0.3 does so at g (sin - mu cos).
TEST(DenseSlope, SticksOrSlides) {
  EXPECT_NEAR(speed_on_slope(0.4, 0.5, 30), 0, 1e-9);
  EXPECT_NEAR(speed_on_slope(0.4, 0.3, 30), 0.5 * g * (std::sin(0.4) - 0.3 * std::cos(0.4)), 1e-9);
}

// A sliding sphere: friction mu m g against the slip, and its moment turns the sphere.
TYPED_TEST(DensePhysics, SlidingFrictionIsMuTimesNormal) {
  using real = TypeParam;
  BodyDescription ball = sphere_body({0, 0, 1}, 1, {3, 4, 0});
  InitialState<real> state = make_worlds<real>({{ball, plane_body()}}, 16);
  state.params.theta = 1;
  set_material(state, 0.2, 0);
  use_dense(state, 1);
  const Buffers<real> after = run_steps(state, 10);
  const double lost = 0.2 * g * 10 / 60, rounding = sizeof(real) == 4 ? 1e-5 : 1e-13;
  EXPECT_NEAR(double(after.motions[0].v[0]), 3 - 0.6 * lost, rounding);
  EXPECT_NEAR(double(after.motions[0].v[1]), 4 - 0.8 * lost, rounding);
}

// No number of contacts is too many for a body: 200 balls that fly at the surface of a large one.
TYPED_TEST(DensePhysics, ABodyHasAnyNumberOfContacts) {
  using real = TypeParam;
  const u32 count = 200;
  std::vector<BodyDescription> bodies = strewn_ball(count);
  for (u32 i = 1; i < bodies.size(); ++i) bodies[i].velocity[2] = -2;
  InitialState<real> state = make_worlds<real>({bodies}, 2048);  // and a block for each that has no colour
  use_dense(state, 100);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  state.params.theta = 1;
  const Buffers<real> after = run_steps(state, 1);
  ASSERT_EQ(after.counters[COUNTER_CONTACTS], count);
  const u32 tiles = (count + PACK - 1) / PACK;
  EXPECT_EQ(after.counters[COUNTER_COUPLED_TILES_NEEDED], tiles * tiles);  // all of them feel each other
  EXPECT_LT(double(after.motions[0].v[2]), -0.05);
  expect_all_are_stopped(bodies, after);
}

// Without friction the velocities at the end are unique, however many contacts share a load.
TEST(DenseConverges, WhereGaussSeidelDoes) {
  InitialState<double> colors = heap<double>(8, 40, 2048);
  set_material(colors, 0, 0);
  InitialState<double> dense = colors;
  use_dense(dense);
  run_until_prepared(colors);
  run_until_prepared(dense);
  colors.params.iterations = dense.params.iterations = 20000;
  expect_both_converge_alike(colors, dense);
}

// With more sweeps less of each contact's law is violated.
TEST(DenseConverges, TheResidualFalls) {
  std::vector<BodyDescription> bodies = {plane_body()};
  for (u32 i = 0; i < 6; ++i) bodies.push_back(box_body({0, 0, 0.5 + i}, {0.5, 0.5, 0.5}));
  InitialState<double> state = make_worlds<double>({bodies}, 64);
  state.params.theta = 1;
  double last = 1;
  for (const u32 sweeps : {1u, 10u, 100u, 1000u}) {
    use_dense(state, sweeps);
    const Buffers<double> after = run_steps(state, 1);
    const double current = residual(contact_system(after, after.counters), 0x1p-53).relative;
    EXPECT_LT(current, 0.8 * last) << sweeps;
    last = current;
  }
  EXPECT_LT(last, 5e-3);
}

// Joints and contacts take turns: a doll that lands does so as with Gauss-Seidel, as both all but converge.
TYPED_TEST(DensePhysics, ADollLandsAsWithGaussSeidel) {
  using real = TypeParam;
  Scene scene = read_scene("rag_doll");
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.iterations = 60;
  const InitialState<real> colors = compile<real>(scene);
  replace_solver(scene.settings, Solver::dense_gauss_seidel);
  scene.settings.iterations = 60;
  const InitialState<real> dense = compile<real>(scene);
  const Buffers<real> a = run_steps(colors, 30), b = run_steps(dense, 30);
  for (u32 i = 0; i < a.positions.size(); ++i) {
    EXPECT_NEAR(double(a.positions[i].x), double(b.positions[i].x), 0.02) << i;
    EXPECT_NEAR(double(a.positions[i].z), double(b.positions[i].z), 0.02) << i;
  }
}

}  // namespace
}  // namespace lockstep::test::dense_physics_test
