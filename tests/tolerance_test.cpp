// Sweeps that end by a tolerance: the twins in every way to sweep, what a change of velocity is counted as, and what a
// tolerance buys and saves.
#include <gtest/gtest.h>

#include <cmath>

#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "tests/jacobi_scene.hpp"
#include "tests/joints/joint_scene.hpp"
#include "tests/patch_scene.hpp"

namespace lockstep::test::tolerance_test {
namespace {

template <class real>
class Tolerance : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Tolerance, Precisions);

template <class real>
void use_tolerance(InitialState<real>& state, double tolerance, u32 at_most) {
  state.features = with(state.features, Feature::tolerance) & ~static_cast<Features>(Feature::coupled_normals);
  state.buffers.normal_couplings.clear();
  state.params.tolerance = real(tolerance);
  state.params.iterations = at_most;
}

// Up to the sweeps of the first sub-step.
template <class real>
InitialState<real> started(InitialState<real> state) {
  for (const Stage stage : {Stage::prepare_contacts, Stage::warm_start})
    reference::run_stage(stage, state.buffers, state.params);
  return state;
}

// A sub-step that ends early, and one that does not.
template <class real>
void solve_twins(InitialState<real> state, double tolerance) {
  for (const bool ends : {true, false}) {
    const u32 at_most = ends ? 500 : 3;
    use_tolerance(state, ends ? tolerance : 1e-6, at_most);
    const Buffers<real> after = run_one_stage<real>(Stage::solve_constraints, state.buffers, state.sizes,
                                                    state.features, state.params, launch_options({{0, 7}, {1, 0}}));
    EXPECT_GT(after.counters[COUNTER_SWEEPS], 1u);
    EXPECT_EQ(after.counters[COUNTER_SWEEPS] < at_most, ends) << after.counters[COUNTER_SWEEPS];
    EXPECT_EQ(after.counters[COUNTER_UNSOLVED], ends ? 0u : 1u);
    EXPECT_EQ(after.counters[COUNTER_SWEEP_CHANGE], 0u);  // the next sub-step starts afresh
    EXPECT_EQ(after.counters[COUNTER_SETTLED], 0u);
  }
}

// Columns of balls that fall on their ground, each in a world of its own.
template <class real>
InitialState<real> columns(u32 count) {
  std::vector<BodyDescription> column = {plane_body()};
  for (u32 i = 0; i < 6; ++i) column.push_back(sphere_body({0, 0, 0.5 + i}, 0.5, {0, 0, -1.0 - i}));
  return make_worlds<real>(std::vector<std::vector<BodyDescription>>(count, column), 8 * count);
}

// Colours in one work-group, in a launch each, and with overflow blocks.
TYPED_TEST(Tolerance, ColorsMatchTheReference) {
  using real = TypeParam;
  InitialState<real> small = heap<real>(6, 12, 256), large = columns<real>(300);
  run_until_prepared(small);
  run_until_prepared(large);
  solve_twins(started(small), 0.1);
  solve_twins(started(large), 0.1);
  solve_twins(star_problem<real>(200), 0.5);
}

TYPED_TEST(Tolerance, BodyCopiesMatchTheReference) {
  using real = TypeParam;
  InitialState<real> large = columns<real>(300);
  use_jacobi(large);
  run_until_prepared(large);
  solve_twins(started(prepared_heap<real>(6, 12, 256, false)), 0.5);
  solve_twins(started(large), 0.1);
}

TYPED_TEST(Tolerance, PatchesMatchTheReference) {
  using real = TypeParam;
  solve_twins(started(patch_pile<real>(true)), 0.25);
}

// Joints alone, in one work-group and in a launch for each large phase.
TYPED_TEST(Tolerance, JointsMatchTheReference) {
  using real = TypeParam;
  const Scene scene = random_joints(4, 40, 30);
  for (const u32 worlds : {1u, 60u}) {
    InitialState<real> state = compile<real>(std::vector<Scene>(worlds, scene));
    ASSERT_EQ(state.buffers.joint_phases[1] >= LARGE_COLOR, worlds > 1);
    run_reference(state, {Stage::begin_step, Stage::integrate_velocities, Stage::prepare_joints, Stage::warm_start});
    solve_twins(state, 0.5);
  }
}

// Whole steps of joints and contacts, in which nothing may depend on lanes, work-groups or threads.
TYPED_TEST(Tolerance, StepsMatchTheReference) {
  using real = TypeParam;
  for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps, Solver::jacobi, Solver::dense_gauss_seidel}) {
    Scene scene = read_scene("rag_doll");
    replace_solver(scene.settings, solver);
    scene.settings.iterations = 20;
    scene.settings.tolerance = 0.01;
    std::vector<DeviceOptions> launches = launch_options({{0, 7}, {8, 4}, {1, 0}});
    launches.front().threads = 1;
    expect_twins_agree(compile<real>(scene), 12, launches);
  }
}

TYPED_TEST(Tolerance, AbortedStepsWriteNothing) {
  using real = TypeParam;
  InitialState<real> state = random_problem<real>(8, 30, 60);
  use_tolerance(state, 0.1, 20);
  state.buffers.counters[COUNTER_STATUS] = STATUS_BLOCKS_FULL;
  const Buffers<real> after = run_twins(Stage::solve_constraints, state);
  EXPECT_EQ(after.counters[COUNTER_SWEEPS], 0u);
  for (u32 i = 0; i < 30; ++i) EXPECT_EQ(after.motions[i].v[0], state.buffers.motions[i].v[0]);
}

// A tolerance that is never met changes nothing but the count; without one nothing is counted.
TYPED_TEST(Tolerance, OneThatIsTooSmallChangesNoBit) {
  using real = TypeParam;
  InitialState<real> state = heap<real>(3, 60, 4096);
  const Buffers<real> plain = run_steps(state, 3);
  use_tolerance(state, 1e-30, state.params.iterations);
  const Buffers<real> counted = run_steps(state, 3);
  EXPECT_EQ(plain.counters[COUNTER_SWEEPS], 0u);
  EXPECT_EQ(counted.counters[COUNTER_SWEEPS], state.params.iterations);
  EXPECT_EQ(plain.counters[COUNTER_UNSOLVED], 0u);
  EXPECT_EQ(counted.counters[COUNTER_UNSOLVED], 1u);
  for (u32 i = 0; i < state.params.bodies; ++i) {
    for (u32 k = 0; k < 3; ++k) EXPECT_EQ(counted.motions[i].v[k], plain.motions[i].v[k]);
  }
}

// ---- what counts as a change ----------------------------------------------------------------------------------------

// Sweeps that one step makes.
u32 sweeps_of(InitialState<double> state, double tolerance) {
  use_tolerance(state, tolerance, 50);
  return run_steps(state, 1).counters[COUNTER_SWEEPS];
}

// The first sweep changes a velocity by `size` m/s and solves the problem; the second finds nothing to do.
void expect_change(const InitialState<double>& state, double size) {
  EXPECT_EQ(sweeps_of(state, size * (1 + 1e-6)), 1u);
  EXPECT_EQ(sweeps_of(state, size * (1 - 1e-6)), 2u);
}

InitialState<double> weightless(const BodyDescription& body, double friction) {
  InitialState<double> state = make_worlds<double>({{body, plane_body()}}, 16);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  state.params.theta = 1;
  set_material(state, friction, 0);
  return state;
}

// A ball that sticks where it hits the ground at 3 m/s down and 4 m/s along.
TEST(SweepChange, OfAContactIsThatOfItsRelativeVelocity) {
  expect_change(weightless(sphere_body({0, 0, 1}, 1, {0, 0, -3}), 0), 3);
  expect_change(weightless(sphere_body({0, 0, 1}, 1, {4, 0, -3}), 10), 5);
}

TEST(SweepChange, OfAGeneralContactIsThatOfItsRelativeVelocity) {
  BodyDescription body = sphere_body({0, 0, 0.5}, 0.5, {1, -0.5, -2});
  body.inertia = {0.1, 0.06, 0.02};
  body.shapes[0].offset = {0.2, 0.1, 0};
  body.angular_velocity = {1, 3, 2};
  InitialState<double> state = make_worlds<double>({{body, plane_body()}}, 16);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  state.params.theta = 1;
  state.params.gyroscopic = 0;
  set_material(state, 50, 0);  // it sticks: the velocity of the point at (0.2, 0.1, -0.5) is taken away
  const double u[3] = {1 + 3 * -0.5 - 2 * 0.1, -0.5 + 2 * 0.2 - 1 * -0.5, -2 + 1 * 0.1 - 3 * 0.2};
  expect_change(state, std::hypot(u[0], u[1], u[2]));
}

// A box that spins on its face comes to rest by the twist; it counts as fast as it turns at its radius of gyration.
TEST(SweepChange, OfATwistIsThatAtTheRadiusOfGyration) {
  InitialState<double> state = box_on_ground<double>({0.5, 0.5, 0.5}, 1000);
  state.buffers.motions[0].w[2] = 5;
  expect_change(state,
                5 * std::sqrt(double(state.buffers.masses[0].inertia[2]) / double(state.buffers.masses[0].mass)));
}

TEST(SweepChange, OfAJointIsThatAtItsAnchorAndOfItsRotation) {
  const auto jointed = [](JointKind kind, const Vector3& velocity, const Vector3& angular_velocity) {
    BodyDescription body = bare_body({0, 0, 0});
    body.velocity = velocity;
    body.angular_velocity = angular_velocity;
    Scene scene = joint_scene({body}, {joint_of(kind, NONE, 0, {0, 0, 0})}, 1.0 / 240);
    scene.gravity = {0, 0, 0};
    return compile<double>(scene);
  };
  expect_change(jointed(JOINT_BALL, {0, 0.25, 0}, {0, 0, 0}), 0.25);
  expect_change(jointed(JOINT_FIXED, {0, 0, 0}, {0, 0, 2}), 2 * std::sqrt(0.1 / 1));
  expect_change(jointed(JOINT_FIXED, {0.3, 0, 0}, {0, 0, 2}), std::hypot(0.3, 2 * std::sqrt(0.1 / 1)));
}

// ---- what it buys, what it saves ------------------------------------------------------------------------------------

struct Solved {
  double residual;
  u32 sweeps;
};

// The state of a scene after some steps, with impulses to start from.
InitialState<double> warm(Scene scene, u32 steps) {
  replace_solver(scene.settings, Solver::gauss_seidel);
  InitialState<double> state = compile<double>(scene);
  state.buffers = run_steps(state, int(steps));
  return state;
}

Solved solved_to(InitialState<double> state, double tolerance) {
  use_tolerance(state, tolerance, 50000);
  const Buffers<double> after = run_steps(state, 1);
  Counters counters;
  std::copy_n(after.counters.begin(), counters.size(), counters.begin());
  return {measure(after, state.sizes, state.features, state.params, counters).residual->relative,
          counters[COUNTER_SWEEPS]};
}

// Decade by decade more sweeps, and less is left of the problem.
void expect_residual_follows(const InitialState<double>& state) {
  Solved last = solved_to(state, 0.1);
  const double first = last.residual;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5}) {
    const Solved current = solved_to(state, tolerance);
    EXPECT_GE(current.sweeps, last.sweeps) << tolerance;
    EXPECT_LE(current.residual, last.residual) << tolerance;
    last = current;
  }
  EXPECT_LT(last.sweeps, 50000u);
  EXPECT_LT(last.residual, 0.04 * first);  // it starts from impulses that are good, and from poses that are
}

Scene small_pyramid() {
  Scene scene;
  for (u32 row = 0; row < 5; ++row) {
    for (u32 i = 0; i + row < 5; ++i)
      scene.bodies.push_back(box_body({1.1 * i + 0.55 * row, 0, 0.5 + row}, {0.5, 0.5, 0.5}));
  }
  scene.bodies.push_back(plane_body());
  scene.materials = {{"stone", 0.5, 0}};
  return scene;
}

TEST(ToleranceBuys, AResidualOfContacts) { expect_residual_follows(warm(small_pyramid(), 10)); }

TEST(ToleranceBuys, AResidualOfJointsAndContacts) { expect_residual_follows(warm(read_scene("rag_doll"), 60)); }

// What lies still starts from the impulses that hold it.
TEST(ToleranceSaves, MostSweepsOfAPyramidAtRest) {
  InitialState<double> state = compile<double>(small_pyramid());
  use_tolerance(state, 1e-3, 1000);
  ReferenceBackend<double> backend(state);
  std::vector<u32> sweeps;
  for (u32 i = 0; i < 120; ++i) {
    step(backend, state.params);
    sweeps.push_back(backend.buffers().counters[COUNTER_SWEEPS]);
  }
  EXPECT_GT(sweeps[0], 20u);
  u32 resting = 0;  // of the last second
  for (u32 i = 60; i < 120; ++i) resting += sweeps[i];
  EXPECT_LT(resting, 2 * 60u);
}

}  // namespace
}  // namespace lockstep::test::tolerance_test
