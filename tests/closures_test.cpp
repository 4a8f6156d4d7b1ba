// Joints that close loops of trees, solved with them: the twins, which ones there are, and what they hold.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/articulation_scene.hpp"

namespace lockstep::test::closures_test {
namespace {

template <class real>
class Closures : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Closures, Precisions);

// ---- the twins -----------------------------------------------------------------------------------------------------

TYPED_TEST(Closures, KernelsMatchReference) {
  for (const Scene& scene : {random_mechanism(1, 20, 3), random_mechanism(2, 60, 16), random_mechanism(3, 900, 7),
                             solved_directly(random_joints(4, 40, 30))})
    expect_stages_agree<TypeParam>(scene, Feature::closures);
}

// In many worlds, in one launch and in several, with sub-steps and to a tolerance.
TYPED_TEST(Closures, StepsMatchReference) {
  using real = TypeParam;
  Scene scene = random_mechanism(5, 30, 4);
  scene.settings.iterations = 2;
  expect_twins_agree(compile<real>(scene), 4, launches_of_all_threads_and_one());
  const std::vector<Scene> worlds(150, scene);
  expect_twins_agree(compile<real>(worlds), 2, launch_options({{1, 7}}));
  scene.settings.substeps = 3;
  scene.settings.tolerance = 1e-3;
  scene.settings.iterations = 5;
  expect_twins_agree(compile<real>(scene), 3);
}

// ---- which there are -----------------------------------------------------------------------------------------------

// A ladder of so many rungs: two chains that hang, and bars across.
Scene ladder(u32 rungs) {
  Scene scene = joint_scene({}, {}, 0.01);
  for (u32 i = 0; i < rungs; ++i) {
    for (const double x : {0.0, 1.0}) scene.bodies.push_back(bare_body({x, 0, -double(i)}));
    for (const u32 side : {0u, 1u}) {
      const Vector3 anchor = {double(side), 0, 0.5 - double(i)};
      scene.joints.push_back(joint_of(JOINT_BALL, i == 0 ? NONE : 2 * i - 2 + side, 2 * i + side, anchor));
    }
    scene.joints.push_back(joint_of(JOINT_BALL, 2 * i, 2 * i + 1, {0.5, 0, -double(i)}));
  }
  return solved_directly(scene);
}

// The chains are two trees, which the rungs make one.
TYPED_TEST(Closures, AreThoseOfOneTree) {
  const InitialState<TypeParam> state = compile<TypeParam>(ladder(MAX_CLOSURES));
  const Buffers<TypeParam>& b = state.buffers;
  ASSERT_EQ(b.articulations.size(), 1u);
  EXPECT_EQ(b.links.size(), 2 * MAX_CLOSURES);
  EXPECT_EQ(b.closure_sets[0].count, MAX_CLOSURES);
  EXPECT_EQ(b.closure_sets[0].links, 2 * MAX_CLOSURES);
  for (const ClosureInfo& closure : b.closures) {
    EXPECT_EQ(closure.joint % 3, 2u);
    EXPECT_EQ(b.links[closure.link_a].body, b.joint_infos[closure.joint].body_a);
    EXPECT_EQ(b.links[closure.link_b].body, b.joint_infos[closure.joint].body_b);
  }
  for (const JointInfo& joint : b.joint_infos) EXPECT_EQ(joint.direct, 1u);
}

// One more than can be, and all of them are swept, of trees of their own.
TYPED_TEST(Closures, AreSweptWhereTheyAreTooMany) {
  const InitialState<TypeParam> state = compile<TypeParam>(ladder(MAX_CLOSURES + 1));
  EXPECT_FALSE(has(state.features, Feature::closures));
  EXPECT_TRUE(state.buffers.closure_matrix.empty());
  EXPECT_EQ(state.buffers.articulations.size(), 2u);
  for (std::size_t j = 0; j < state.buffers.joint_infos.size(); ++j)
    EXPECT_EQ(state.buffers.joint_infos[j].direct, j % 3 == 2 ? 0u : 1u);
  expect_twins_agree(state, 2, launch_options({{16, 0}}));
}

// ---- what they hold ------------------------------------------------------------------------------------------------

// In two of them a loop holds what is nearly held without it.
TYPED_TEST(Closures, OneSolveIsExact) {
  using real = TypeParam;
  for (const u32 seed : {6u, 7u, 8u, 9u, 10u, 11u, 12u, 13u}) {
    SCOPED_TRACE(seed);
    Scene scene = random_mechanism(seed, 60, 5);
    scene.bodies[0].velocity =
        scene.bodies[0].angular_velocity = {};                    // what is held to the world may be held to it too
    EXPECT_GE(compile<real>(scene).buffers.closures.size(), 4u);  // one may hold a tree that floats
    const double rounding = seed == 7 || seed == 10 ? 1e-5 : 1e-10;
    expect_one_solve_is_exact<real>(scene, sizeof(real) == 4 ? 1e-3 : rounding);
  }
}

struct Bridge {
  Scene scene;
  std::vector<double> pulls;  // N: of the joints, along the bridge and up
};

// Planks of a metre and 1 kg between two rocks, one with a load besides, where they hang in balance: with H the pull
// along the bridge, and the pull up growing by a plank's weight from each joint to the next, no plank turns about its
// middle where its slope is the mean pull up of its ends over H (the funicular polygon).
Bridge bridge_in_balance(JointKind kind, u32 planks, double load) {
  constexpr double g = 9.81;
  const double along = 5 * g * (planks + load);
  Bridge bridge = {joint_scene({}, {}, 1.0 / 240), {}};
  double up = -0.5 * g * (planks + load);
  Vector3 end = {0, 0, 0};
  for (u32 i = 0; i < planks; ++i) {
    const double mass = i == planks / 2 ? 1 + load : 1, next = up + g * mass;
    const double slope = std::atan2(0.5 * (up + next), along);
    const Vector3 to = {end[0] + std::cos(slope), 0, end[2] + std::sin(slope)};
    BodyDescription plank = bare_body({0.5 * (end[0] + to[0]), 0, 0.5 * (end[2] + to[2])}, {0.1, 0.2, 0.3});
    plank.mass = mass;
    bridge.scene.bodies.push_back(plank);
    bridge.scene.joints.push_back(joint_of(kind, i == 0 ? NONE : i - 1, i, end, {0, 1, 0}));
    bridge.pulls.push_back(std::hypot(along, up));
    up = next;
    end = to;
  }
  bridge.scene.joints.push_back(joint_of(kind, planks - 1, NONE, end, {0, 1, 0}));
  bridge.pulls.push_back(std::hypot(along, up));
  bridge.scene.settings.iterations = 1;
  bridge.scene = solved_directly(bridge.scene);
  return bridge;
}

// It hangs still, each joint pulls as it is to, and hinges, whose rows hold much of that twice, do no worse. With an
// odd number of planks the load is in the middle.
TYPED_TEST(Closures, ABridgeHangsInBalance) {
  using real = TypeParam;
  const double rounding = sizeof(real) == 4 ? 1e-4 : 1e-10;
  for (const JointKind kind : {JOINT_BALL, JOINT_HINGE}) {
    for (const double load : {0.0, 100.0}) {
      SCOPED_TRACE(std::to_string(kind) + ", load " + std::to_string(load));
      const Bridge bridge = bridge_in_balance(kind, 21, load);
      const InitialState<real> state = compile<real>(bridge.scene);
      ASSERT_EQ(state.buffers.closures.size(), 1u);
      ReferenceBackend<real> backend(state);
      for (u32 i = 0; i < 240; ++i) step(backend, state.params);
      const Buffers<real>& b = backend.buffers();
      for (u32 i = 0; i < bridge.scene.bodies.size(); ++i) {
        EXPECT_NEAR(double(b.positions[i].x), bridge.scene.bodies[i].position[0], rounding) << i;
        EXPECT_NEAR(double(b.positions[i].z), bridge.scene.bodies[i].position[2], rounding) << i;
      }
      reference::for_each_joint_slot(b, [&](const JointLanes& lanes, u32 block, u32 lane) {
        const auto& locked = b.joint_impulses[block].locked;
        const double pull = std::hypot(double(locked[0][lane]), double(locked[1][lane]), double(locked[2][lane])) * 240;
        EXPECT_NEAR(pull / bridge.pulls[lanes.joint[lane]], 1, 100 * rounding) << lanes.joint[lane];
      });
    }
  }
}

// A four-bar linkage with equal cranks keeps its coupler level, at any angle: a parallelogram. Four hinges hold it, of
// which one closes the loop, and nothing but the plane's rows are held twice.
TYPED_TEST(Closures, AParallelogramStaysOne) {
  using real = TypeParam;
  Scene scene = joint_scene({bare_body({0, 0, -0.5}), bare_body({2, 0, -0.5}), bare_body({1, 0, -1})}, {}, 1.0 / 240);
  scene.joints = {
      joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0}, {0, 1, 0}), joint_of(JOINT_HINGE, NONE, 1, {2, 0, 0}, {0, 1, 0}),
      joint_of(JOINT_HINGE, 0, 2, {0, 0, -1}, {0, 1, 0}), joint_of(JOINT_HINGE, 1, 2, {2, 0, -1}, {0, 1, 0})};
  scene.settings.iterations = 1;
  scene.bodies[0].angular_velocity = scene.bodies[1].angular_velocity = {0, -3, 0};
  for (BodyDescription& body : scene.bodies) body.velocity = {3 * std::abs(body.position[2]), 0, 0};
  const InitialState<real> state = compile<real>(solved_directly(scene));
  ASSERT_EQ(state.buffers.closures.size(), 1u);
  ReferenceBackend<real> backend(state);
  const double rounding = sizeof(real) == 4 ? 2e-5 : 1e-10;
  double farthest = 0;
  for (u32 i = 0; i < 480; ++i) {
    step(backend, state.params);
    const Buffers<real>& b = backend.buffers();
    const double x = double(b.positions[2].x) - 1, z = double(b.positions[2].z);
    EXPECT_NEAR(std::hypot(x, z), 1, rounding);
    EXPECT_NEAR(double(b.orientations[2].y), 0, rounding);
    farthest = std::max(farthest, std::abs(x));
  }
  // from energy: 3 kg that move as one, and two cranks that turn besides; w^2 = w_0^2 - 2 m g (1 - cos) / I
  const double inertia = 1 + 2 * (0.25 + 0.1), pull = 9.81 * (1 + 2 * 0.5);
  EXPECT_NEAR(farthest, std::sin(std::acos(1 - 9 * inertia / (2 * pull))), 2e-3);
}

}  // namespace
}  // namespace lockstep::test::closures_test
