#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "cpu_reference/joints/factor.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::prepare_joints_test {
namespace {

template <class real>
class PrepareJoints : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(PrepareJoints, Precisions);

template <class real>
constexpr double rounding = sizeof(real) == 4 ? 1e-5 : 1e-13;

// A state in which impulses have gathered, just before the stage.
template <class real>
InitialState<real> state_before(Stage stage, const Scene& scene) {
  InitialState<real> state = compile<real>(scene);
  ReferenceBackend<real> backend(state);
  step(backend, state.params);
  for (const Stage each : {Stage::begin_step, Stage::integrate_velocities, Stage::prepare_joints, Stage::warm_start,
                           Stage::solve_constraints, Stage::integrate_positions, Stage::relax_constraints}) {
    if (each == stage) break;
    backend.run(each, state.params);
  }
  state.buffers = backend.buffers();
  return state;
}

template <class real>
Buffers<real> run_joint_twins(Stage stage, const Scene& scene) {
  const InitialState<real> state = state_before<real>(stage, scene);
  return run_one_stage<real>(stage, state.buffers, state.sizes, state.features, state.params);
}

// More joints on one body than there are colours.
Scene hub(u32 spokes) {
  Scene scene = random_joints(9, spokes + 1, 0);
  for (u32 i = 1; i <= spokes; ++i) {
    scene.bodies[i].kind = BODY_DYNAMIC;
    if (scene.bodies[i].mass == 0) scene.bodies[i].mass = 1;
    scene.joints.push_back(joint_of(JOINT_BALL, 0, i, scene.bodies[i].position));
  }
  return scene;
}

TYPED_TEST(PrepareJoints, KernelMatchesReference) {
  using real = TypeParam;
  run_joint_twins<real>(Stage::prepare_joints, random_joints(1, 40, 90));
  run_joint_twins<real>(Stage::prepare_joints, with_small_steps(random_joints(2, 300, 700), 2));
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::explicit_euler}) {
    Scene scene = random_joints(10, 40, 90);
    scene.settings.integrator = integrator;
    EXPECT_TRUE(has(compile<real>(scene).features, Feature::joints_ahead));
    run_joint_twins<real>(Stage::prepare_joints, scene);
    run_joint_twins<real>(Stage::prepare_joints, with_impedances(scene));
  }
}

// What sweeps the joints belongs to stages that they share with the contacts.
TYPED_TEST(PrepareJoints, SweepsMatchReference) {
  using real = TypeParam;
  for (const Stage stage : {Stage::warm_start, Stage::solve_constraints, Stage::relax_constraints}) {
    SCOPED_TRACE(info(stage).name);
    run_joint_twins<real>(stage, with_small_steps(random_joints(3, 40, 90), 2));
    run_joint_twins<real>(stage, with_small_steps(random_joints(4, 4000, 3000), 2));
    run_joint_twins<real>(stage, with_small_steps(hub(80), 2));
    run_joint_twins<real>(stage, with_small_steps(with_impedances(random_joints(3, 40, 90)), 2));
  }
}

TYPED_TEST(PrepareJoints, StepsMatchReference) {
  using real = TypeParam;
  Scene scene = random_joints(5, 30, 40);
  scene.settings.iterations = 3;
  expect_twins_agree(compile<real>(scene), 5);
  scene.settings.integrator = Integrator::trapezoidal;
  expect_twins_agree(compile<real>(scene), 5);
}

// Each joint stands once in the blocks; those of one colour share no movable body.
TYPED_TEST(PrepareJoints, BlocksContainEachJointOnce) {
  using real = TypeParam;
  const InitialState<real> state = compile<real>(random_joints(6, 100, 500));
  const Buffers<real>& b = state.buffers;
  std::vector<u32> seen(b.joints.size(), 0);
  ASSERT_EQ(b.joint_phases.back(), b.joint_lanes.size());
  for (u32 phase = 0; phase + 1 < b.joint_phases.size(); ++phase) {
    std::vector<u32> used(b.body_infos.size() + 1, 0);
    ASSERT_LT(b.joint_phases[phase], b.joint_phases[phase + 1]);
    for (u32 block = b.joint_phases[phase]; block < b.joint_phases[phase + 1]; ++block) {
      for (u32 lane = 0; lane < PACK; ++lane) {
        const JointLanes& lanes = b.joint_lanes[block];
        if (lanes.joint[lane] == NONE) continue;
        ++seen[lanes.joint[lane]];
        for (const u32 body : {lanes.body_a[lane], lanes.body_b[lane]}) {
          const bool moves = body < b.body_infos.size() && b.body_infos[body].kind == BODY_DYNAMIC;
          EXPECT_EQ(moves ? used[body]++ : 0, 0u);
        }
      }
    }
  }
  for (const u32 times : seen) EXPECT_EQ(times, 1u);
}

TYPED_TEST(PrepareJoints, WhatFindsNoColourIsSolvedAlone) {
  using real = TypeParam;
  const InitialState<real> state = compile<real>(hub(MAX_COLORS + 6));
  EXPECT_EQ(state.sizes.joint_phases, MAX_COLORS + 6);
  Scene scene = hub(MAX_COLORS + 6);
  scene.settings.iterations = 200;
  scene.settings.correction = 0;
  scene.bodies[0].mass = 1000;  // so that the sweeps converge
  scene.bodies[0].inertia = {1000, 1000, 1000};
  for (BodyDescription& body : scene.bodies) body.angular_velocity = {0, 0, 0};  // no arm turns yet
  const Buffers<real> b = after_steps<real>(scene, 1);
  // the hub carries all: no spoke moves against it at its anchor, its own centre
  const Motion<real>& m = b.motions[0];
  for (u32 i = 1; i <= MAX_COLORS + 6; ++i) {
    const Vector3 arm = exact::subtract(scene.bodies[i].position, scene.bodies[0].position);
    const Vector3 from_rotation = exact::cross({double(m.w[0]), double(m.w[1]), double(m.w[2])}, arm);
    for (u32 k = 0; k < 3; ++k) EXPECT_NEAR(double(b.motions[i].v[k]), double(m.v[k]) + from_rotation[k], 1e-4) << i;
  }
}

// L D L^T is K again, row by row, and what is not locked stays out.
TYPED_TEST(PrepareJoints, FactorSolvesTheLockedRows) {
  using real = TypeParam;
  Random random(3);
  for (const u32 locked : {63u, 31u, 59u, 7u, 0u}) {
    real root[JOINT_ROWS][JOINT_ROWS], k[JOINT_ROWS][JOINT_ROWS], x[JOINT_ROWS], b[JOINT_ROWS];
    for (auto& row : root)
      for (real& entry : row) entry = real(random.between(-1, 1));
    for (u32 i = 0; i < JOINT_ROWS; ++i) {
      x[i] = (locked >> i & 1) != 0 ? real(random.between(-1, 1)) : real(0);
      for (u32 j = 0; j < JOINT_ROWS; ++j) {
        k[i][j] = i == j ? real(1) : real(0);
        for (u32 n = 0; n < JOINT_ROWS; ++n) k[i][j] += root[i][n] * root[j][n];
      }
    }
    for (u32 i = 0; i < JOINT_ROWS; ++i) {
      b[i] = 0;
      for (u32 j = 0; j < JOINT_ROWS; ++j) b[i] += k[i][j] * x[j];
    }
    reference::solve_factor(reference::factorise(k, locked), b);
    for (u32 i = 0; i < JOINT_ROWS; ++i) EXPECT_NEAR(double(b[i]), double(x[i]), 100 * rounding<real>) << locked;
  }
}

// One solve satisfies a joint with its motor and limits exactly, so that a second sweep changes nothing.
TYPED_TEST(PrepareJoints, OneSolveSatisfiesOneJoint) {
  using real = TypeParam;
  for (u32 seed = 0; seed < 20; ++seed) {
    Scene scene = one_random_joint(seed);
    const Buffers<real> once = after_steps<real>(scene, 1);
    scene.settings.iterations = 2;
    const Buffers<real> twice = after_steps<real>(scene, 1);
    for (u32 k = 0; k < 3; ++k) {
      EXPECT_NEAR(double(once.motions[1].v[k]), double(twice.motions[1].v[k]), 100 * rounding<real>) << seed;
      EXPECT_NEAR(double(once.motions[1].w[k]), double(twice.motions[1].w[k]), 100 * rounding<real>) << seed;
    }
  }
}

TYPED_TEST(PrepareJoints, AbortedStepsWriteNothing) {
  using real = TypeParam;
  for (const Stage stage :
       {Stage::prepare_joints, Stage::warm_start, Stage::solve_constraints, Stage::relax_constraints}) {
    InitialState<real> state = state_before<real>(stage, with_small_steps(random_joints(7, 20, 30), 2));
    state.buffers.counters[COUNTER_STATUS] = STATUS_PAIRS_FULL;
    const Buffers<real> after = run_one_stage<real>(stage, state.buffers, state.sizes, state.features, state.params,
                                                    launch_options({{0, 0}, {1, 0}}));
    EXPECT_EQ(std::memcmp(after.joint_impulses.data(), state.buffers.joint_impulses.data(),
                          after.joint_impulses.size() * sizeof(after.joint_impulses[0])),
              0);
    EXPECT_EQ(std::memcmp(after.motions.data(), state.buffers.motions.data(),
                          after.motions.size() * sizeof(after.motions[0])),
              0);
  }
}

// Every impulse is part of the state, wherever its joint lies in the blocks.
TYPED_TEST(PrepareJoints, ImpulsesAreHashed) {
  using real = TypeParam;
  InitialState<real> state = state_before<real>(Stage::count, random_joints(8, 10, 20));
  const auto hash = [&] {
    reference::run_stage(Stage::hash_state, state.buffers, state.params);
    return state.buffers.world_hashes[0].state_low;
  };
  run_one_stage<real>(Stage::hash_state, state.buffers, state.sizes, state.features, state.params);
  const u32 before = hash();
  for (u32 slot = 0; slot < state.sizes.joint_blocks * PACK; ++slot) {
    const u32 lane = slot % PACK;
    const bool is_joint = state.buffers.joint_lanes[slot / PACK].joint[lane] != NONE;
    JointImpulseBlock<real>& impulses = state.buffers.joint_impulses[slot / PACK];
    for (real* word : {&impulses.locked[0][lane], &impulses.locked[5][lane], &impulses.free[lane]}) {
      const real old = *word;
      *word = old + 1;
      EXPECT_EQ(hash() != before, is_joint) << slot;
      *word = old;
    }
  }
}

}  // namespace
}  // namespace lockstep::test::prepare_joints_test
