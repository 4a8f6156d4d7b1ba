#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/contact_scene.hpp"

namespace lockstep::test::solve_constraints_test {
namespace {

template <class real>
class SolveConstraints : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SolveConstraints, Precisions);

template <class real>
constexpr double tolerance = sizeof(real) == 4 ? 1e-5 : 1e-12;

// A unit sphere on the ground.
template <class real>
InitialState<real> ball_on_ground(Vector3 velocity, double friction, double restitution) {
  InitialState<real> state = make_worlds<real>({{sphere_body({0, 0, 1}, 1, velocity), plane_body()}}, 16);
  set_material(state, friction, restitution);
  state.params.theta = 1;
  return state;
}

TYPED_TEST(SolveConstraints, KernelMatchesReference) {
  using real = TypeParam;
  InitialState<real> small = random_problem<real>(1, 40, 90), large = random_problem<real>(2, 900, 5000);
  large.params.iterations = 3;
  InitialState<real> overflowing = star_problem<real>(200);
  run_twins(Stage::solve_constraints, small);
  run_twins(Stage::solve_constraints, large);
  run_twins(Stage::solve_constraints, overflowing);
}

// Without the feature the kernel has no code for general contacts: the bits of central ones are the same.
TYPED_TEST(SolveConstraints, CentralKernelMatchesReference) {
  using real = TypeParam;
  Random random(5);
  const auto [kinds, graph] = random_graph(random, 300, 1500);
  InitialState<real> state = prepared(contact_graphs<real>({kinds}, {with_manifolds(random, graph)}));
  for (BlockBodies& block : state.buffers.block_bodies) {
    for (u32& kind : block.kind) kind = kind == BLOCK_GENERAL ? u32{BLOCK_CENTRAL} : kind;
  }
  state.features &= ~static_cast<Features>(Feature::general_contacts);
  run_twins(Stage::solve_constraints, state);
}

// Immovable bodies are read by many lanes and written by none; padding stays zero.
TYPED_TEST(SolveConstraints, LeavesImmovableBodiesAndPaddingAlone) {
  using real = TypeParam;
  const InitialState<real> state = random_problem<real>(6, 50, 200);
  const Buffers<real> after = run_twins(Stage::solve_constraints, state);
  for (u32 i = 0; i <= state.params.bodies; ++i) {
    if (state.buffers.motions[i].inverse_mass > 0) continue;
    EXPECT_EQ(std::memcmp(&after.motions[i], &state.buffers.motions[i], sizeof(Motion<real>)), 0) << i;
  }
  std::vector<bool> used(after.counters[COUNTER_ROWS] * PACK);
  for (u32 i = 0; i < after.counters[COUNTER_CONTACTS]; ++i) used[after.contact_slots[i]] = true;
  for (u32 slot = 0; slot < used.size(); ++slot) {
    if (used[slot]) continue;
    EXPECT_EQ(after.impulse_blocks[slot / PACK].normal[slot % PACK], 0);
    EXPECT_EQ(after.impulse_blocks[slot / PACK].tangent_1[slot % PACK], 0);
    EXPECT_EQ(after.impulse_blocks[slot / PACK].tangent_2[slot % PACK], 0);
  }
}

TYPED_TEST(SolveConstraints, ImpactBouncesByNewtonsLaw) {
  using real = TypeParam;
  InitialState<real> state = ball_on_ground<real>({0, 0, -3}, 0, 0.6);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  const Buffers<real> after = run_steps(state, 1);
  EXPECT_NEAR(double(after.motions[0].v[2]), 1.8, tolerance<real>);
}

// Two balls of different mass in a row: momentum, and the relative velocity times -e.
TYPED_TEST(SolveConstraints, ImpactOfTwoBalls) {
  using real = TypeParam;
  expect_they_bounced(run_steps(balls_that_bounce<real>(), 1), tolerance<real>);
}

// A sliding sphere: friction mu m g against the slip, and its moment turns the sphere.
TYPED_TEST(SolveConstraints, SlidingFrictionIsMuTimesNormal) {
  using real = TypeParam;
  const InitialState<real> state = ball_on_ground<real>({3, 4, 0}, 0.2, 0);
  const Buffers<real> after = run_steps(state, 10);
  const double lost = 0.2 * 9.81 * 10 / 60;
  EXPECT_NEAR(double(after.motions[0].v[0]), 3 - 0.6 * lost, 2 * tolerance<real>);
  EXPECT_NEAR(double(after.motions[0].v[1]), 4 - 0.8 * lost, 2 * tolerance<real>);
  EXPECT_NEAR(double(after.motions[0].w[1]), 0.6 * lost / 0.4, 5 * tolerance<real>);
  EXPECT_NEAR(double(after.motions[0].w[0]), -0.8 * lost / 0.4, 5 * tolerance<real>);
}

// On a slope with more friction than 2/7 tan it rolls without slipping: 5/7 g sin.
TYPED_TEST(SolveConstraints, StickingSphereRollsDownASlope) {
  using real = TypeParam;
  const double angle = 0.3;
  const Vector3 normal = {std::sin(angle), 0, std::cos(angle)};
  InitialState<real> state = make_worlds<real>(
      {{sphere_body(normal, 1), plane_body({0, 0, 0}, {0, std::sin(angle / 2), 0, std::cos(angle / 2)})}}, 16);
  set_material(state, 1, 0);
  state.params.theta = 1;
  const Buffers<real> after = run_steps(state, 30);
  const double speed = 5.0 / 7 * 9.81 * std::sin(angle) * 0.5;
  EXPECT_NEAR(double(after.motions[0].v[0]), speed * std::cos(angle), 20 * tolerance<real>);
  EXPECT_NEAR(double(after.motions[0].v[2]), -speed * std::sin(angle), 20 * tolerance<real>);
  EXPECT_NEAR(double(after.motions[0].w[1]), speed, 20 * tolerance<real>);
}

TYPED_TEST(SolveConstraints, ConservesMomentum) {
  using real = TypeParam;
  InitialState<real> state = pair_of_spheres<real>();
  const auto [linear, angular] = momentum(state.buffers);
  reference::run_stage(Stage::solve_constraints, state.buffers, state.params);
  const auto [linear_after, angular_after] = momentum(state.buffers);
  EXPECT_GT(state.buffers.impulse_blocks[0].normal[0], 1);
  const double rounding = sizeof(real) == 4 ? 4e-6 : 1e-14;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(linear_after[k], linear[k], rounding);
    EXPECT_NEAR(angular_after[k], angular[k], 2 * rounding);
  }
}

// A body of its own shape and mass distribution, off its centre: the general block. It stops sliding or slides with
// friction against the slip, and never penetrates.
TYPED_TEST(SolveConstraints, GeneralContactObeysItsLaw) {
  using real = TypeParam;
  BodyDescription body = sphere_body({0, 0, 0.5}, 0.5, {1, -0.5, -2});
  body.inertia = {0.1, 0.06, 0.02};
  body.shapes[0].offset = {0.2, 0.1, 0};
  body.angular_velocity = {1, 3, 2};
  InitialState<real> state = make_worlds<real>({{body, plane_body()}}, 16);
  for (const double friction : {0.0, 0.1, 1.5}) {
    set_material(state, friction, 0);
    InitialState<real> solved = state;
    run_until_prepared(solved);
    Buffers<real>& b = solved.buffers;
    ASSERT_EQ(b.block_bodies[0].kind[0], u32{BLOCK_GENERAL});
    reference::run_stage(Stage::solve_constraints, b, solved.params);
    const ContactBlock<real>& c = b.contact_blocks[0];
    const auto &v = b.motions[0].v, &w = b.motions[0].w;
    const double u[3] = {v[0] + w[1] * c.arm_a_z[0] - w[2] * c.arm_a_y[0],
                         v[1] + w[2] * c.arm_a_x[0] - w[0] * c.arm_a_z[0],
                         v[2] + w[0] * c.arm_a_y[0] - w[1] * c.arm_a_x[0]};
    // normal z, tangents x and y
    const double r_n = b.impulse_blocks[0].normal[0];
    const double r_x = b.impulse_blocks[0].tangent_1[0], r_y = b.impulse_blocks[0].tangent_2[0];
    EXPECT_NEAR(u[2] + double(c.bias[0]), 0, tolerance<real>);
    EXPECT_GT(r_n, 0.1);
    const double slip = std::hypot(u[0], u[1]), friction_impulse = std::hypot(r_x, r_y);
    EXPECT_LE(friction_impulse, friction * r_n * (1 + tolerance<real>));
    if (friction > 1) {
      EXPECT_NEAR(slip, 0, tolerance<real>);
    } else {
      EXPECT_GT(slip, 0.1);
      EXPECT_NEAR(friction_impulse, friction * r_n, tolerance<real>);
      EXPECT_NEAR(u[0] * r_x + u[1] * r_y, -slip * friction_impulse, tolerance<real>);
    }
  }
}

// A stack at rest: each contact carries what is above it, m g dt.
TYPED_TEST(SolveConstraints, StackConvergesToItsWeight) {
  using real = TypeParam;
  const InitialState<real> state = column_of_balls<real>(6);
  expect_column_bears_its_weight(run_steps(state, 100), 6, 1e-4);  // warm starts do what sweeps do
}

// More contacts on one body than there are colours: the overflow is solved as well.
TYPED_TEST(SolveConstraints, OverflowIsSolved) {
  using real = TypeParam;
  const u32 count = 200;
  const std::vector<BodyDescription> bodies = strewn_ball(count);
  InitialState<real> state = make_worlds<real>({bodies}, 1024);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  state.sizes.blocks = state.params.block_capacity = 1024;
  state.sizes.rows = state.params.row_capacity = 1024;
  resize(state.buffers, state.sizes, state.features);
  state.params.theta = 1;
  const Buffers<real> after = run_steps(state, 1);
  EXPECT_EQ(after.counters[COUNTER_OVERFLOW], count - MAX_COLORS);
  for (u32 i = 1; i <= count; ++i) EXPECT_NEAR(leaving_speed(bodies, after, i), 0, 1e-3) << i;
}

TYPED_TEST(SolveConstraints, AbortedStepsWriteNothing) {
  using real = TypeParam;
  InitialState<real> state = random_problem<real>(8, 30, 60);
  state.buffers.counters[COUNTER_STATUS] = STATUS_BLOCKS_FULL;
  const Buffers<real> after = run_twins(Stage::solve_constraints, state);
  for (u32 i = 0; i < 30; ++i)
    EXPECT_EQ(std::memcmp(&after.motions[i], &state.buffers.motions[i], sizeof(Motion<real>)), 0);
}

}  // namespace
}  // namespace lockstep::test::solve_constraints_test
