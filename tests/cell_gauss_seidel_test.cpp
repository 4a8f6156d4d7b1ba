// Gauss-Seidel cell by cell: the twins of every stage that knows it, and what it must share with the sweeps over
// colours: momentum, impacts, friction, weight, and where it converges to.
#include <gtest/gtest.h>

#include "host/report/residual.hpp"
#include "host/scene/read.hpp"
#include "tests/cell_scene.hpp"

namespace lockstep::test::cell_gauss_seidel_test {
namespace {

template <class real>
class CellGaussSeidel : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CellGaussSeidel, Precisions);

template <class real>
constexpr double tolerance = sizeof(real) == 4 ? 1e-5 : 1e-12;

// A heap on both sides of the origin, cells of some bodies each, ready to be solved.
template <class real>
InitialState<real> prepared_cells(u32 seed, u32 count, u32 pairs, bool uses_patches) {
  InitialState<real> state = heap<real>(seed, count, pairs);
  state.sizes.blocks = state.params.block_capacity = state.sizes.rows = state.params.row_capacity = pairs;
  if (uses_patches) state.features = with(state.features, Feature::patches);
  use_cells(state, 0.7);
  run_until_prepared(state);
  draw_start_impulses(seed, state);
  reference::run_stage(Stage::pack_points, state.buffers, state.params);
  return state;
}

template <class real>
u32 pairs_in_cells(const Buffers<real>& b) {
  u32 pairs = 0;
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) pairs += b.contact_colors[i] == COLOR_OF_CELL;
  return pairs;
}

// Small enough for one work-group, and not; cones, and patches.
TYPED_TEST(CellGaussSeidel, KernelMatchesReference) {
  using real = TypeParam;
  for (const bool large : {false, true}) {
    InitialState<real> state =
        large ? prepared_cells<real>(5, 400, 8192, true) : prepared_cells<real>(6, 12, 256, false);
    ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], large ? 1000u : 20u);
    ASSERT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
    ASSERT_GT(pairs_in_cells(state.buffers), large ? 500u : 10u);
    for (const Stage stage :
         {Stage::partition_contacts, Stage::schedule_contacts, Stage::color_contacts, Stage::pack_contacts,
          Stage::prepare_contacts, Stage::warm_start, Stage::solve_constraints})
      state.buffers = run_twins(stage, state);
  }
}

// Pairs in cells, in colours and in the overflow: bodies with more pairs than all of these hold.
TYPED_TEST(CellGaussSeidel, PairsInNoCellMatchTheReference) {
  using real = TypeParam;
  InitialState<real> state = prepared(graphs_in_cells<real>(7, {{300, 1200}, {4, 700}}));
  ASSERT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
  ASSERT_GT(pairs_in_cells(state.buffers), 100u);
  ASSERT_GT(state.buffers.counters[COUNTER_COLORS], 4u);
  ASSERT_GT(state.buffers.counters[COUNTER_OVERFLOW], 20u);
  for (const Stage stage : {Stage::color_contacts, Stage::pack_contacts, Stage::warm_start, Stage::solve_constraints})
    state.buffers = run_twins(stage, state);
}

// Whole steps, in which nothing may depend on lanes, work-groups or threads; with a tolerance too.
TYPED_TEST(CellGaussSeidel, StepsMatchTheReference) {
  using real = TypeParam;
  InitialState<real> state = heap<real>(7, 60, 4096);
  use_cells(state, 0.9);
  expect_twins_agree(state, 8, launches_of_all_threads_and_one());
  state.features = with(state.features, Feature::tolerance);
  state.params.tolerance = real(0.2);
  state.params.iterations = 20;
  expect_twins_agree(state, 4, launch_options({{16, 7}, {1, 0}}));
}

// Joints are swept before the contacts; who touches is told.
TYPED_TEST(CellGaussSeidel, JointsAndEventsMatchTheReference) {
  using real = TypeParam;
  Scene scene = read_scene("rag_doll");
  replace_solver(scene.settings, Solver::cell_gauss_seidel);
  scene.settings.events = true;
  const InitialState<real> state = compile<real>(scene);
  ASSERT_TRUE(has(state.features, Feature::partitions));
  EXPECT_FALSE(runs(Stage::relax_constraints, state.features));
  expect_twins_agree(state, 60, launch_options({{16, 7}}));
}

// Blocks that do not fit are left out, and the rest is as sound: the step is redone.
TYPED_TEST(CellGaussSeidel, KernelMatchesReferenceWhereBlocksAreFull) {
  using real = TypeParam;
  InitialState<real> state = prepared_cells<real>(5, 100, 2048, false);
  state.sizes.blocks = state.params.block_capacity = 7;
  state.sizes.rows = state.params.row_capacity = 16;
  resize(state.buffers, state.sizes, state.features);
  const Buffers<real> after = run_twins(Stage::pack_contacts, state);
  EXPECT_NE(after.counters[COUNTER_STATUS] & STATUS_BLOCKS_FULL, 0u);
  EXPECT_NE(after.counters[COUNTER_STATUS] & STATUS_ROWS_FULL, 0u);
}

TYPED_TEST(CellGaussSeidel, AbortedStepsWriteNothing) {
  using real = TypeParam;
  InitialState<real> state = prepared_cells<real>(9, 12, 256, false);
  state.buffers.counters[COUNTER_STATUS] = STATUS_PAIRS_FULL;
  for (const Stage stage : {Stage::warm_start, Stage::solve_constraints}) {
    const Buffers<real> after = run_twins(stage, state);
    for (u32 i = 0; i < state.params.bodies; ++i) {
      for (u32 k = 0; k < 3; ++k) EXPECT_EQ(after.motions[i].v[k], state.buffers.motions[i].v[k]);
    }
  }
}

// A world has the bits in a batch that it has alone.
TYPED_TEST(CellGaussSeidel, WorldsDoNotMeet) {
  using real = TypeParam;
  Scene scene = read_scene("cell_heap"), other = read_scene("spheres_small");
  other.settings = scene.settings;
  const InitialState<real> alone = compile<real>(scene), batch = compile<real>(std::vector<Scene>{other, scene, scene});
  expect_world_is_as_alone(run_steps(batch, 120), 2, run_steps(alone, 120));
}

TYPED_TEST(CellGaussSeidel, ConservesMomentum) {
  using real = TypeParam;
  InitialState<real> state = balls_that_collide<real>();
  use_cells(state, 0.6);
  run_until_prepared(state);
  ASSERT_GT(pairs_in_cells(state.buffers), 100u);
  expect_solving_keeps_momentum(state, sizeof(real) == 4 ? 1e-4 : 2e-13);
}

// Two balls of different mass, with a face of the cells between them and with their centres on faces: momentum, and the
// relative velocity times -e.
TYPED_TEST(CellGaussSeidel, ImpactOfTwoBalls) {
  using real = TypeParam;
  for (const double left_x : {-0.5, 0.0, -1.0, 0.25}) {
    InitialState<real> state = balls_that_bounce<real>(left_x);
    use_cells(state, 1);
    const Buffers<real> after = run_steps(state, 1);
    ASSERT_EQ(pairs_in_cells(after), 1u);
    expect_they_bounced(after, tolerance<real>);
  }
}

// On 0.3 rad a ball rolls by 5/7 g sin where friction is enough, and where it is 0.05 slides by g (sin - mu cos).
TYPED_TEST(CellGaussSeidel, FrictionOnASlope) {
  using real = TypeParam;
  const double angle = 0.3, g = 9.81, time = 0.5;
  for (const double friction : {1.0, 0.05}) {
    InitialState<real> state =
        make_worlds<real>({{sphere_body({std::sin(angle), 0, std::cos(angle)}, 1),
                            plane_body({0, 0, 0}, {0, std::sin(angle / 2), 0, std::cos(angle / 2)})}},
                          16);
    set_material(state, friction, 0);
    use_cells(state, 0.5);
    state.params.theta = 1;
    const Buffers<real> after = run_steps(state, 30);
    ASSERT_EQ(pairs_in_cells(after), 1u);
    const double speed =
        time * g * (friction > 0.5 ? 5.0 / 7 * std::sin(angle) : std::sin(angle) - friction * std::cos(angle));
    EXPECT_NEAR(double(after.motions[0].v[0]), speed * std::cos(angle), 20 * tolerance<real>);
    EXPECT_NEAR(double(after.motions[0].v[2]), -speed * std::sin(angle), 20 * tolerance<real>);
  }
}

// Each ball of a column carries what is above it, m g dt; the column stands in several cells, and on their faces.
TYPED_TEST(CellGaussSeidel, AColumnOfBallsBearsItsWeight) {
  using real = TypeParam;
  for (const double size : {1.5, 1.0, 20.0}) {
    InitialState<real> state = column_of_balls<real>(6);
    use_cells(state, size);
    state.params.iterations = 1000;
    const Buffers<real> after = run_steps(state, 1);
    EXPECT_EQ(pairs_in_cells(after), 6u);
    expect_column_bears_its_weight(after, 6, sizeof(real) == 4 ? 1e-4 : 1e-10);
  }
}

// More pairs on one body than batches and colours hold. Far from the hub's cell, some of them near it, all in the eight
// cells about the origin, all in one: no ball goes on into the hub.
TYPED_TEST(CellGaussSeidel, ALargeBodyAmongSmallOnes) {
  using real = TypeParam;
  const u32 count = 200;
  const std::vector<BodyDescription> bodies = strewn_ball(count);
  struct Case {
    double size, shift;
    u32 least, most;  // pairs in cells
  };
  for (const Case& c :
       {Case{1, 0, 0, 0}, {7, 0, 20, 180}, {50, 0, count, count}, {50, 25, CELL_BATCHES, CELL_BATCHES}}) {
    SCOPED_TRACE(c.size + c.shift);
    InitialState<real> state = make_worlds<real>({bodies}, 1024);
    state.buffers.gravities[0] = {0, 0, 0, 0};
    state.sizes.blocks = state.params.block_capacity = 1024;
    state.sizes.rows = state.params.row_capacity = 1024;
    use_cells(state, c.size);
    for (Vec4<real>& at : state.buffers.positions) at.x += real(c.shift), at.y += real(c.shift), at.z += real(c.shift);
    state.params.theta = 1;
    const Buffers<real> after = run_steps(state, 1);
    const u32 in_cells = pairs_in_cells(after), others = count - in_cells;
    EXPECT_GE(in_cells, c.least);
    EXPECT_LE(in_cells, c.most);
    EXPECT_EQ(after.counters[COUNTER_COLORS], std::min(MAX_COLORS, others));
    EXPECT_EQ(after.counters[COUNTER_OVERFLOW], others - std::min(MAX_COLORS, others));
    for (u32 i = 1; i <= count; ++i) EXPECT_NEAR(leaving_speed(bodies, after, i), 0, 1e-3) << i;
  }
}

// Without friction the velocities at the end are unique, however many contacts share a load.
TEST(CellGaussSeidelConverges, WhereGaussSeidelDoes) {
  InitialState<double> sweeps = heap<double>(8, 40, 2048);
  set_material(sweeps, 0, 0);
  InitialState<double> cells = sweeps;
  use_cells(cells, 0.8);
  run_until_prepared(sweeps);
  run_until_prepared(cells);
  ASSERT_GT(pairs_in_cells(cells.buffers), 30u);
  sweeps.params.iterations = cells.params.iterations = 20000;
  expect_both_converge_alike(sweeps, cells);
}

// With friction the residual of the canonical problem falls with the sweeps.
TEST(CellGaussSeidelConverges, ResidualFallsWithTheSweeps) {
  Scene scene = read_scene("spheres_small");
  replace_solver(scene.settings, Solver::cell_gauss_seidel);
  scene.settings.cell_size = 1.5;
  double last = 1;
  for (const u32 sweeps : {5u, 20u, 80u, 320u}) {
    scene.settings.iterations = sweeps;
    const Buffers<double> after = run_steps(compile<double>(scene), 60);
    ASSERT_GT(after.counters[COUNTER_CONTACTS], 50u);
    const double current = residual(contact_system(after, after.counters), 0x1p-53).relative;
    EXPECT_LT(current, 0.2 * last) << sweeps;
    last = current;
  }
  EXPECT_LT(last, 1e-12);
}

}  // namespace
}  // namespace lockstep::test::cell_gauss_seidel_test
