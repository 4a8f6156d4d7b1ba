// Joints of trees, solved all at once: the twins, which trees there are, and that one solve is exact.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cpu_reference/joints/visit_joint.hpp"
#include "host/scene/read.hpp"
#include "tests/articulation_scene.hpp"
#include "tests/contact_scene.hpp"

namespace lockstep::test {
namespace {

template <class real>
class FactorArticulations : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(FactorArticulations, Precisions);

// A state in which impulses have gathered, just before the stage.
template <class real>
InitialState<real> state_before(Stage stage, const Scene& scene) {
  InitialState<real> state = compile<real>(scene);
  ReferenceBackend<real> backend(state);
  step(backend, state.params);
  for (const Stage each :
       {Stage::begin_step, Stage::integrate_velocities, Stage::prepare_joints, Stage::factor_articulations,
        Stage::warm_start, Stage::solve_constraints, Stage::integrate_positions, Stage::close_joints}) {
    if (each == stage) break;
    backend.run(each, state.params);
  }
  state.buffers = backend.buffers();
  return state;
}

// Joints that close loops, soft ones, motors and limits beside trees; trees alone; many bodies, which take launches of
// their own.
std::vector<Scene> scenes_with_trees() {
  return {solved_directly(random_joints(1, 40, 60)), random_tree(2, 60), random_tree(3, 900),
          solved_directly(random_joints(4, 2000, 2500))};
}

TYPED_TEST(FactorArticulations, KernelMatchesReference) {
  using real = TypeParam;
  for (const Scene& scene : scenes_with_trees()) {
    for (const Stage stage : {Stage::factor_articulations, Stage::solve_constraints, Stage::close_joints}) {
      SCOPED_TRACE(info(stage).name);
      const InitialState<real> state = state_before<real>(stage, scene);
      ASSERT_TRUE(has(state.features, Feature::articulations));
      ASSERT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
      run_twins(stage, state);
    }
  }
}

// With sub-steps, that small scenes run as one launch; with a tolerance; ahead of the step.
TYPED_TEST(FactorArticulations, StepsMatchReference) {
  using real = TypeParam;
  Scene scene = random_tree(5, 40);
  scene.settings.iterations = 2;
  expect_twins_agree(compile<real>(scene), 4, launches_of_all_threads_and_one());
  scene.settings.substeps = 3;
  scene.settings.tolerance = 1e-3;
  scene.settings.iterations = 5;
  expect_twins_agree(compile<real>(scene), 3);
  scene = solved_directly(random_joints(6, 40, 50));
  scene.settings.integrator = Integrator::trapezoidal;
  expect_twins_agree(compile<real>(scene), 4);
}

TYPED_TEST(FactorArticulations, ScenesMatchReference) {
  using real = TypeParam;
  for (const auto& [name, steps] : {std::pair("rag_doll", 60), {"rover", 30}, {"sweeper", 20}, {"bricard", 20}}) {
    SCOPED_TRACE(name);
    Scene scene = read_scene(name);
    for (const Solver solver : {Solver::gauss_seidel, Solver::cell_gauss_seidel}) {
      if (solver == Solver::cell_gauss_seidel && std::string_view(name) != "rag_doll") continue;
      use_solver(scene.settings, solver);
      const InitialState<real> state = compile<real>(solved_directly(scene));
      ASSERT_TRUE(has(state.features, Feature::articulations));
      expect_twins_agree(state, steps, launch_options({{1, 7}, {16, 0}}));
    }
  }
}

// Whole trees fall asleep and wake.
TYPED_TEST(FactorArticulations, SleepersMatchTheReference) {
  using real = TypeParam;
  Scene scene = read_scene("mobile");
  scene.settings.sleeping = SleepSettings{.after = 0.05, .speed = 10, .angular_speed = 10};
  const InitialState<real> state = compile<real>(scene);
  EXPECT_LT(run_steps(state, 12).sleepers[0].island, ISLAND_WAKES);
  expect_twins_agree(state, 12, launch_options({{16, 7}, {1, 0}}));
}

// Too many of them for one work-group.
TYPED_TEST(FactorArticulations, ManyDollsMatchTheReference) {
  using real = TypeParam;
  Scene scene = read_scene("rag_doll");
  use_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.iterations = 3;
  for (BodyDescription& body : scene.bodies) body.velocity[2] -= 8;
  const InitialState<real> state = compile<real>(std::vector<Scene>(100, solved_directly(scene)));
  ASSERT_GE(state.sizes.links, LARGE_COLOR * PACK);
  expect_twins_agree(state, 15, launch_options({{16, 0}, {1, 7}}));
}

// ---- which trees there are -----------------------------------------------------------------------------------------

// Each movable body that a hard joint holds is one link; a parent stands before its children, one level above; whatever
// joint is left closes a loop, or is soft.
TYPED_TEST(FactorArticulations, ForestsSpanTheBodies) {
  using real = TypeParam;
  const InitialState<real> state = compile<real>(solved_directly(random_joints(7, 200, 260)));
  const Buffers<real>& b = state.buffers;
  std::vector<u32> tree_of(b.body_infos.size() + 1, NONE), level_of(b.links.size(), NONE);
  std::vector<bool> solves(b.joint_infos.size(), false);
  for (u32 t = 0; t < b.articulations.size(); ++t) {
    const Articulation& tree = b.articulations[t];
    for (u32 level = 0; level < tree.level_count; ++level) {
      for (u32 i = b.link_levels[tree.first_level + level]; i < b.link_levels[tree.first_level + level + 1]; ++i) {
        const LinkInfo& link = b.links[i];
        ASSERT_EQ(b.body_infos[link.body].kind, u32{BODY_DYNAMIC});
        ASSERT_EQ(tree_of[link.body], NONE) << "a body is two links";
        tree_of[link.body] = t;
        level_of[i] = level;
        EXPECT_EQ(link.parent == NONE, level == 0);
        if (link.parent != NONE) {
          EXPECT_EQ(level_of[link.parent], level - 1);
          EXPECT_LE(b.links[link.parent].first_child, i);
          EXPECT_LT(i, b.links[link.parent].first_child + b.links[link.parent].child_count);
        }
        if (link.joint == NONE) continue;
        solves[link.joint] = true;
        EXPECT_EQ(b.joint_lanes[link.slot / PACK].joint[link.slot % PACK], link.joint);
        const JointInfo& joint = b.joint_infos[link.joint];
        EXPECT_EQ(link.is_b != 0 ? joint.body_b : joint.body_a, link.body);
      }
    }
  }
  u32 direct = 0;
  for (u32 j = 0; j < b.joint_infos.size(); ++j) {
    const JointInfo& joint = b.joint_infos[j];
    EXPECT_EQ(joint.direct != 0, solves[j] && joint.free == FREE_NOTHING);
    direct += joint.direct;
    if (b.joints[j].spring > 0 || solves[j]) continue;
    const u32 a = tree_of[joint.body_a], c = tree_of[joint.body_b];
    EXPECT_TRUE(a != NONE || c != NONE) << j;  // one of them is held already
  }
  EXPECT_GT(direct, 20u);
  EXPECT_GT(std::ranges::count(solves, false), 20);
}

// ---- one solve is exact --------------------------------------------------------------------------------------------

// What the rows of a tree are off by: the largest, m/s and rad/s. Springs push against what they give way by.
template <class real>
double most_off(const Buffers<real>& b) {
  double most = 0;
  for (const LinkInfo& link : b.links) {
    if (link.joint == NONE) continue;
    const JointInfo& info = b.joint_infos[link.joint];
    const JointBlock<real>& block = b.joint_blocks[link.slot / PACK];
    const u32 lane = link.slot % PACK;
    const Motion<real>&body_a = b.motions[info.body_a], &body_b = b.motions[info.body_b];
    const auto u = reference::velocity_at(reference::joint_vector(block.arm_b, lane),
                                          reference::joint_vector(block.arm_a, lane), body_b, body_a);
    const auto w = reference::sub3(reference::vec3(body_b.w), reference::vec3(body_a.w));
    for (u32 row = 0; row < JOINT_ROWS; ++row) {
      if ((info.locked >> row & 1) == 0) continue;
      const auto axis = reference::joint_vector(block.axes + 3 * (row % 3), lane);
      double off = double(reference::dot3(axis, row < 3 ? u : w)) + double(block.bias[row][lane]) +
                   double(block.turning[row][lane]);
      if (row == 2) off -= double(block.rise[lane]) * double(reference::dot3(axis, w));
      most = std::max(most, std::abs(off));
    }
    if (info.free == FREE_NOTHING || block.slowest[lane] != block.fastest[lane]) continue;
    const auto along = reference::joint_vector(block.free_axis, lane);
    const double free = double(reference::dot3(along, info.free == FREE_ANGLE ? w : u));
    const double push = double(block.yield[lane]) * double(b.joint_impulses[link.slot / PACK].free[lane]);
    most = std::max(most, std::abs(free - double(block.slowest[lane]) + push));
  }
  return most;
}

// Their velocities, and M (v - v before) is what the impulses of the joints push with: together the one solution.
TYPED_TEST(FactorArticulations, OneSolveIsExact) {
  using real = TypeParam;
  const double rounding = sizeof(real) == 4 ? 2e-4 : 1e-11;
  for (const u32 seed : {8u, 9u, 10u, 11u}) {
    Scene scene = random_tree(seed, 50);
    scene.settings.iterations = 1;
    InitialState<real> state = state_before<real>(Stage::solve_constraints, scene);
    Buffers<real> pushed = state.buffers;
    EXPECT_GT(most_off(state.buffers), 0.1);
    reference::run_stage(Stage::solve_constraints, state.buffers, state.params);
    EXPECT_LT(most_off(state.buffers), rounding);
    reference::for_each_joint_slot(pushed, [&](const JointLanes& lanes, u32 block, u32 lane) {
      real change[JOINT_ROWS];
      for (u32 row = 0; row < JOINT_ROWS; ++row)
        change[row] =
            state.buffers.joint_impulses[block].locked[row][lane] - pushed.joint_impulses[block].locked[row][lane];
      const real free = state.buffers.joint_impulses[block].free[lane] - pushed.joint_impulses[block].free[lane];
      reference::push_joint(pushed.joint_blocks[block], lanes.free[lane], lane, change, free,
                            pushed.motions[lanes.body_a[lane]], pushed.motions[lanes.body_b[lane]]);
    });
    for (u32 i = 0; i < state.params.bodies; ++i) {
      for (u32 k = 0; k < 3; ++k) {
        EXPECT_NEAR(double(state.buffers.motions[i].v[k]), double(pushed.motions[i].v[k]), rounding) << i;
        EXPECT_NEAR(double(state.buffers.motions[i].w[k]), double(pushed.motions[i].w[k]), rounding) << i;
      }
    }
  }
}

// ---- what the program refuses, and what it costs nobody else -------------------------------------------------------

TEST(JointSolver, GoesWithGaussSeidel) {
  Scene scene = random_tree(12, 5);
  scene.source = "a.json";
  for (const Solver solver : {Solver::jacobi, Solver::small_steps, Solver::gradient, Solver::dense_gauss_seidel}) {
    use_solver(scene.settings, solver);
    EXPECT_EQ(scene.settings.joint_solver, JointSolver::sweeps);
    try {
      compile<float>(solved_directly(scene));
      ADD_FAILURE() << "was not refused";
    } catch (const Error& error) {
      EXPECT_STREQ(error.what(),
                   "a.json: /settings/joint_solver: direct goes with the solvers gauss_seidel and cell_gauss_seidel; "
                   "take one of them, or sweeps");
    }
  }
}

TEST(JointSolver, CostsNothingWhereNoTreeIs) {
  Scene scene = random_tree(13, 5);
  for (JointDescription& joint : scene.joints) joint.frequency = 3;
  const InitialState<float> state = compile<float>(scene);
  EXPECT_FALSE(has(state.features, Feature::articulations));
  EXPECT_TRUE(state.buffers.link_factors.empty());
  EXPECT_FALSE(runs(Stage::factor_articulations, state.features));
}

}  // namespace
}  // namespace lockstep::test
