#include "tests/coupling_scene.hpp"

namespace lockstep::test::prepare_couplings_test {
namespace {

template <class real>
class PrepareCouplings : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(PrepareCouplings, Precisions);

template <class real>
constexpr double rounding = sizeof(real) == 4 ? 1e-4 : 1e-12;

// A state in which impulses have gathered, just before the stage.
template <class real>
InitialState<real> state_before(Stage stage, const Scene& scene) {
  InitialState<real> state = compile<real>(scene);
  ReferenceBackend<real> backend(state);
  step(backend, state.params);
  for (const Stage each : {Stage::begin_step, Stage::integrate_velocities, Stage::prepare_joints,
                           Stage::prepare_couplings, Stage::warm_start, Stage::solve_constraints,
                           Stage::integrate_positions, Stage::close_joints, Stage::relax_constraints}) {
    if (each == stage) break;
    if (runs(each, state.features)) backend.run(each, state.params);
  }
  state.buffers = backend.buffers();
  return state;
}

template <class real>
void run_coupling_twins(Stage stage, const Scene& scene) {
  const InitialState<real> state = state_before<real>(stage, scene);
  run_one_stage<real>(stage, state.buffers, state.sizes, state.features, state.params);
}

TYPED_TEST(PrepareCouplings, KernelMatchesReference) {
  using real = TypeParam;
  for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::trapezoidal}) {
    Scene scene = random_couplings(random_joints(1, 40, 90), 60);
    scene.settings.integrator = integrator;
    run_coupling_twins<real>(Stage::prepare_couplings, scene);
    run_coupling_twins<real>(Stage::prepare_couplings, random_couplings(with_impedances(scene), 60));
  }
  run_coupling_twins<real>(Stage::prepare_couplings,
                           with_small_steps(random_couplings(random_joints(2, 300, 700), 200), 2));
}

// What sweeps the couplings belongs to stages that they share with joints and contacts.
TYPED_TEST(PrepareCouplings, SweepsMatchReference) {
  using real = TypeParam;
  const Scene scene = with_small_steps(random_couplings(with_impedances(random_joints(3, 40, 90)), 60), 2);
  for (const Stage stage : {Stage::warm_start, Stage::solve_constraints, Stage::relax_constraints}) {
    SCOPED_TRACE(info(stage).name);
    run_coupling_twins<real>(stage, scene);
    run_coupling_twins<real>(stage, with_small_steps(random_couplings(random_joints(4, 3000, 3000), 900), 2));
  }
  run_coupling_twins<real>(Stage::hash_state, scene);
}

TYPED_TEST(PrepareCouplings, StepsMatchReference) {
  using real = TypeParam;
  Scene scene = random_couplings(with_impedances(random_joints(5, 30, 40)), 30);
  scene.settings.iterations = 3;
  expect_twins_agree(compile<real>(scene), 4);
  scene.settings.tolerance = 1e-3;
  expect_twins_agree(compile<real>(scene), 4);
  scene.settings.tolerance = 0;
  expect_twins_agree(compile<real>(with_small_steps(scene, 2)), 4);
  scene.settings.integrator = Integrator::trapezoidal;
  scene.settings.solver = Solver::jacobi;
  expect_twins_agree(compile<real>(scene), 4);
}

TYPED_TEST(PrepareCouplings, StepsBesideContactsMatchReference) {
  using real = TypeParam;
  for (const Solver solver : {Solver::gauss_seidel, Solver::cell_gauss_seidel, Solver::jacobi, Solver::small_steps}) {
    SCOPED_TRACE(name_of(solver));
    Scene scene = gripper_on_floor(0.2);
    replace_solver(scene.settings, solver);
    const InitialState<real> state = compile<real>(scene);
    expect_twins_agree(state, 12, launch_options({{8, 0}}));
    ReferenceBackend<real> backend(state);
    for (u32 i = 0; i < 12; ++i) step(backend, state.params);
    EXPECT_GT(backend.buffers().counters[COUNTER_CONTACTS], 0u);
  }
}

// Each stands once in a phase, and those of one share no body that can move.
TYPED_TEST(PrepareCouplings, PhasesShareNoBody) {
  using real = TypeParam;
  const InitialState<real> state = compile<real>(random_couplings(random_joints(6, 30, 200), 300));
  const Buffers<real>& b = state.buffers;
  ASSERT_EQ(b.coupling_phases.front(), 0u);
  ASSERT_EQ(b.coupling_phases.back(), 300u);
  std::vector<u32> seen(300, 0);
  for (u32 phase = 0; phase + 1 < b.coupling_phases.size(); ++phase) {
    std::vector<u32> user(b.body_infos.size() + 1, NONE);
    for (u32 k = b.coupling_phases[phase]; k < b.coupling_phases[phase + 1]; ++k) {
      const CouplingInfo& info = b.coupling_infos[k];
      ++seen[info.id];
      for (u32 i = info.first; i < info.first + info.count; ++i) {
        for (const u32 body : {b.coupled_joints[i].body_a, b.coupled_joints[i].body_b}) {
          if (body >= b.body_infos.size() || b.body_infos[body].kind != BODY_DYNAMIC) continue;
          EXPECT_TRUE(user[body] == NONE || user[body] == k);
          user[body] = k;
        }
      }
    }
  }
  for (const u32 times : seen) EXPECT_EQ(times, 1u);
}

// The mobility is what a unit of its impulse changes its velocity by, locked rows and rotors answering: one solve of a
// coupling alone does all that it wants.
TYPED_TEST(PrepareCouplings, OneSolveIsExact) {
  using real = TypeParam;
  Scene scene = gripper(0.3);
  scene.joints[1].armature = 0.4;
  const InitialState<real> state = state_before<real>(Stage::solve_constraints, scene);
  Buffers<real> b = state.buffers;
  const auto speed = [&] {
    real u = 0;
    reference::for_each_coupled(b, 0, [&](u32 block, u32 lane, const CoupledJoint& joint, real ratio) {
      const auto response = reference::coupled_response(reference::Purpose::solve, b.joint_blocks[block], lane);
      u += ratio * reference::coupled_velocity(response, b.joint_blocks[block], joint.free, lane,
                                               b.joint_impulses[block], b.motions[joint.body_a],
                                               b.motions[joint.body_b]);
    });
    return double(u);
  };
  b.coupling_rows[0].slowest = b.coupling_rows[0].fastest = real(0.7);
  b.coupling_rows[0].bound_softness = 0;
  reference::solve_coupling(reference::Purpose::solve, b, 0);
  EXPECT_NEAR(speed(), 0.7, rounding<real>);
  EXPECT_NE(b.coupling_impulses[0].bound, real(0));
}

TYPED_TEST(PrepareCouplings, CostNothingWhereThereAreNone) {
  using real = TypeParam;
  Scene scene = gripper(0.3);
  const InitialState<real> with = compile<real>(scene);
  EXPECT_TRUE(has(with.features, Feature::couplings));
  scene.couplings.clear();
  const InitialState<real> without = compile<real>(scene);
  EXPECT_FALSE(has(without.features, Feature::couplings));
  EXPECT_TRUE(without.buffers.coupling_rows.empty() && without.buffers.coupling_phases.empty());
}

}  // namespace
}  // namespace lockstep::test::prepare_couplings_test
