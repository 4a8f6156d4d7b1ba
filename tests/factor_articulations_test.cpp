// Joints of trees, solved all at once: the twins, which trees there are, and that one solve is exact.
#include <gtest/gtest.h>

#include <algorithm>

#include "host/scene/read.hpp"
#include "tests/articulation_scene.hpp"

namespace lockstep::test::factor_articulations_test {
namespace {

template <class real>
class FactorArticulations : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(FactorArticulations, Precisions);

// Joints that close loops, soft ones, motors and limits beside trees; trees alone; many bodies, which take launches of
// their own.
std::vector<Scene> scenes_with_trees() {
  return {solved_directly(random_joints(1, 40, 60)), random_tree(2, 60), random_tree(3, 900),
          solved_directly(random_joints(4, 2000, 2500))};
}

TYPED_TEST(FactorArticulations, KernelMatchesReference) {
  for (const Scene& scene : scenes_with_trees()) expect_stages_agree<TypeParam>(scene, Feature::articulations);
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
      replace_solver(scene.settings, solver);
      const InitialState<real> state = compile<real>(solved_directly(scene));
      ASSERT_TRUE(has(state.features, Feature::articulations));
      expect_twins_agree(state, steps, launch_options({{1, 7}, {16, 0}}));
    }
  }
}

// Whole trees at rest fall asleep.
TYPED_TEST(FactorArticulations, SleepersMatchTheReference) {
  using real = TypeParam;
  Scene scene = read_scene("mobile");
  scene.gravity = {0, 0, 0};
  for (auto& body : scene.bodies) body.velocity = body.angular_velocity = {0, 0, 0};
  for (auto& joint : scene.joints) joint.spring = {};
  scene.settings.sleeping = SleepSettings{.after = 0.05};
  const InitialState<real> state = compile<real>(scene);
  EXPECT_LT(run_steps(state, 12).sleepers[0].island, ISLAND_WAKES);
  expect_twins_agree(state, 12, launch_options({{16, 7}, {1, 0}}));
}

// Too many of them for one work-group.
TYPED_TEST(FactorArticulations, ManyDollsMatchTheReference) {
  using real = TypeParam;
  Scene scene = read_scene("rag_doll");
  replace_solver(scene.settings, Solver::gauss_seidel);
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
  for (const ClosureInfo& closure : b.closures) {
    EXPECT_FALSE(solves[closure.joint]);
    solves[closure.joint] = true;
  }
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

TYPED_TEST(FactorArticulations, OneSolveIsExact) {
  for (const u32 seed : {8u, 9u, 10u, 11u})
    expect_one_solve_is_exact<TypeParam>(random_tree(seed, 50), sizeof(TypeParam) == 4 ? 2e-4 : 1e-11);
}

// ---- what the program refuses, and what it costs nobody else -------------------------------------------------------

TEST(JointSolver, GoesWithGaussSeidel) {
  Scene scene = random_tree(12, 5);
  scene.source = "a.json";
  for (const Solver solver : {Solver::jacobi, Solver::small_steps, Solver::gradient, Solver::dense_gauss_seidel}) {
    replace_solver(scene.settings, solver);
    EXPECT_EQ(scene.settings.joint_solver, JointSolver::automatic);
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
}  // namespace lockstep::test::factor_articulations_test
