// What joints of trees do when they are solved all at once, in closed form and beside sweeps that have converged.
#include <gtest/gtest.h>

#include <cmath>

#include "host/report/joints.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "tests/articulation_scene.hpp"
#include "tests/bodies.hpp"
#include "tests/contact_scene.hpp"

namespace lockstep::test::articulation_physics_test {
namespace {

constexpr double g = 9.81;

template <class real>
class ArticulationPhysics : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ArticulationPhysics, Precisions);

/// A chain that hangs from the world, links of 1 m and 1 kg, the last of `end` kg; it starts straight, at an angle.
Scene chain(u32 links, double end, double angle, double dt) {
  std::vector<BodyDescription> bodies;
  std::vector<JointDescription> joints;
  const Vector3 along = {std::sin(angle), 0, -std::cos(angle)};
  for (u32 i = 0; i < links; ++i) {
    bodies.push_back(bare_body((i + 0.5) * along));
    joints.push_back(joint_of(JOINT_BALL, i == 0 ? NONE : i - 1, i, double(i) * along));
  }
  bodies.back().mass = end;
  Scene scene = solved_directly(joint_scene(bodies, joints, dt));
  scene.settings.iterations = 1;
  return scene;
}

// Each joint carries what hangs from it after one solve from nothing, however long the chain.
TYPED_TEST(ArticulationPhysics, AChainCarriesItsWeight) {
  using real = TypeParam;
  const u32 links = 50;
  const Buffers<real> after = after_steps<real>(chain(links, 100, 0, 0.01), 1);
  for (const LinkInfo& link : after.links) {
    const JointImpulseBlock<real>& r = after.joint_impulses[link.slot / PACK];
    const u32 lane = link.slot % PACK;
    const double size = std::hypot(double(r.locked[0][lane]), double(r.locked[1][lane]), double(r.locked[2][lane]));
    const double weight = (links - 1 - link.joint + 100) * g * 0.01;
    EXPECT_NEAR(size / weight, 1, sizeof(real) == 4 ? 1e-4 : 1e-12) << link.joint;
  }
}

// A long chain with a heavy end that swings: no joint opens, and little energy goes.
TYPED_TEST(ArticulationPhysics, AHeavyChainStaysWhole) {
  using real = TypeParam;
  Scene scene = chain(64, 100, 1.2, 1.0 / 240);
  scene.settings.integrator = Integrator::trapezoidal;
  double worst = 0;
  watch_steps<real>(scene, 240,
                    [&](const Buffers<real>& b, u32) { worst = std::max(worst, joint_drift(b).separation); });
  EXPECT_LT(worst, sizeof(real) == 4 ? 1e-4 : 1e-8);
}

// Impulses are equal and opposite: what floats keeps its momentum, and its angular momentum but for the turning of a
// step.
TYPED_TEST(ArticulationPhysics, ATreeThatFloatsKeepsItsMomentum) {
  using real = TypeParam;
  Scene scene = random_tree(21, 30);
  for (JointDescription& joint : scene.joints) {  // nothing holds on to the world
    if (joint.body_a == NONE || joint.body_a == 0) joint.body_a = 1;
    if (joint.body_b == NONE || joint.body_b == 0) joint.body_b = 1;
    if (joint.body_a == joint.body_b) joint.body_b = 2;
  }
  for (BodyDescription& body : scene.bodies) body.inertia = {1, 1, 1};
  InitialState<real> state = compile<real>(scene);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  resize(state.buffers, state.sizes, state.features);
  for (const Stage stage : {Stage::begin_step, Stage::integrate_velocities, Stage::prepare_joints,
                            Stage::factor_articulations, Stage::warm_start})
    reference::run_stage(stage, state.buffers, state.params);
  const auto [linear, angular] = momentum(state.buffers);
  reference::run_stage(Stage::solve_constraints, state.buffers, state.params);
  const auto [linear_after, angular_after] = momentum(state.buffers);
  for (u32 k = 0; k < 3; ++k) {
    EXPECT_NEAR(linear_after[k], linear[k], sizeof(real) == 4 ? 5e-4 : 1e-11);
    EXPECT_NEAR(angular_after[k], angular[k], sizeof(real) == 4 ? 2e-3 : 1e-10);
  }
}

// Motors, limits, springs, screws, dry friction and loops have the same answer; what is no tree takes sweeps. One step:
// joints are closed otherwise, which carries angular velocities.
TEST(Articulations, EndWhereGaussSeidelDoes) {
  for (const char* name : {"governor", "pendulum_chain", "screw_nut", "cardan_shaft", "slider_crank", "turntable"}) {
    SCOPED_TRACE(name);
    Scene scene = read_scene(name);
    replace_solver(scene.settings, Solver::gauss_seidel);
    scene.settings.tolerance = 0;
    const auto after = [&](JointSolver solver, u32 iterations) {
      scene.settings.joint_solver = solver;
      scene.settings.iterations = iterations;
      return after_steps<double>(scene, 1);
    };
    const Buffers<double> sweeps = after(JointSolver::sweeps, 20000), direct = after(JointSolver::direct, 4000);
    expect_same_velocities(direct, sweeps, 5);
  }
}

// A doll that lands does so as with sweeps, as both all but converge.
TYPED_TEST(ArticulationPhysics, ADollLandsAsWithSweeps) {
  using real = TypeParam;
  Scene scene = read_scene("rag_doll");
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.iterations = 60;
  const Buffers<real> a = after_steps<real>(scene, 30), b = after_steps<real>(solved_directly(scene), 30);
  for (u32 i = 0; i < a.positions.size(); ++i) {
    EXPECT_NEAR(double(a.positions[i].x), double(b.positions[i].x), 0.01) << i;
    EXPECT_NEAR(double(a.positions[i].z), double(b.positions[i].z), 0.01) << i;
  }
}

// A spring on the hinge of a bar is an oscillator, solved by its tree.
TYPED_TEST(ArticulationPhysics, ASpringOnAHingeSwings) {
  using real = TypeParam;
  const double stiffness = 8, inertia = 0.5, dt = 1e-3;
  BodyDescription bar = bare_body({0, 0, 0}, {inertia, inertia, inertia});
  bar.angular_velocity = {0, 0, 1};
  JointDescription hinge = joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0});
  hinge.spring = {.stiffness = stiffness, .damping = 0, .rest = 0};
  Scene scene = solved_directly(joint_scene({bar}, {hinge}, dt));
  scene.settings.integrator = Integrator::trapezoidal;
  scene.settings.iterations = 1;
  const double rate = std::sqrt(stiffness / inertia);
  watch_steps<real>(scene, 1500, [&](const Buffers<real>& b, u32 i) {
    if (i % 100 != 99) return;
    EXPECT_NEAR(double(b.motions[0].w[2]), std::cos(rate * (i + 1) * dt), sizeof(real) == 4 ? 5e-3 : 1e-4) << i;
  });
}

// What is off by e is off by some e^2 once a tree is closed: half of it leaves a quarter.
TYPED_TEST(ArticulationPhysics, ClosesToSecondOrder) {
  using real = TypeParam;
  const auto gap_after = [](double size, u32 sweeps) {
    InitialState<real> state = compile<real>(chain(20, 5, 0.4, 0.01));
    resize(state.buffers, state.sizes, state.features);
    Random random(3);
    for (u32 i = 0; i < state.params.bodies; ++i) {
      const Vector3 displacement = random.vector(size);
      state.buffers.positions[i].x += real(displacement[0]);
      state.buffers.positions[i].y += real(displacement[1]);
      state.buffers.positions[i].z += real(displacement[2]);
    }
    const double before = joint_drift(state.buffers).separation;
    EXPECT_GT(before, size);
    state.params.position_sweeps = sweeps;
    reference::run_stage(Stage::close_joints, state.buffers, state.params);
    return joint_drift(state.buffers).separation;
  };
  EXPECT_GT(gap_after(0.02, 1) / gap_after(0.01, 1), 3.3);
  EXPECT_LT(gap_after(0.02, 1), 0.01);
  EXPECT_LT(gap_after(0.02, 5), sizeof(real) == 4 ? 5e-6 : 1e-13);
}

// A world has the bits in a batch that it has alone.
TYPED_TEST(ArticulationPhysics, WorldsDoNotMeet) {
  using real = TypeParam;
  Scene scene = random_tree(22, 60), other = random_tree(23, 25);
  const Buffers<real> one = after_steps<real>(scene, 5);
  const InitialState<real> batch = compile<real>(std::vector<Scene>{other, scene, scene});
  const Buffers<real> all = run_steps(batch, 5);
  for (const u32 world : {1u, 2u}) {
    const u32 first = all.world_ranges[world].first_body;
    for (u32 i = 0; i < one.body_infos.size(); ++i)
      EXPECT_EQ(std::memcmp(&all.motions[first + i], &one.motions[i], sizeof(Motion<real>)), 0) << i;
  }
}

}  // namespace
}  // namespace lockstep::test::articulation_physics_test
