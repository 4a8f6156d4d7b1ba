// The sums of the impulses of a step's sub-steps: twins, and what they are worth to the bodies that they push.
#include <gtest/gtest.h>

#include "tests/jacobi_scene.hpp"
#include "tests/joints/joint_scene.hpp"
#include "tests/patch_scene.hpp"

namespace lockstep::test::sum_impulses_test {
namespace {

template <class real>
class SumImpulses : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SumImpulses, Precisions);

template <class real>
InitialState<real> summed(InitialState<real> state) {
  state.features = with(state.features, Feature::summed_impulses);
  resize(state.buffers, state.sizes, state.features);
  return state;
}

// The first sub-step, and one that adds to what there is.
template <class real>
void run_both_twins(InitialState<real> state) {
  state = summed(std::move(state));
  state.params.substeps = 4;
  state.buffers = run_twins(Stage::sum_impulses, state);
  state.params.substep = 3;
  run_twins(Stage::sum_impulses, state);
}

TYPED_TEST(SumImpulses, KernelMatchesReference) {
  using real = TypeParam;
  run_both_twins(random_problem<real>(1, 300, 1500));
  run_both_twins(star_problem<real>(100));
  InitialState<real> pile = patch_pile<real>(false);
  for (const Stage stage : {Stage::prepare_contacts, Stage::solve_constraints})
    reference::run_stage(stage, pile.buffers, pile.params);
  run_both_twins(pile);
}

TYPED_TEST(SumImpulses, KernelMatchesReferenceForJoints) {
  using real = TypeParam;
  for (const u32 joints : {90u, 700u}) {
    InitialState<real> state = compile<real>(with_small_steps(random_joints(joints, 60, joints), 2));
    ReferenceBackend<real> backend(state);
    step(backend, state.params);
    state.buffers = backend.buffers();
    run_both_twins(state);
  }
}

// Steps of several sub-steps: m (v' - v) = m g h + the sums of what a body got, for balls and boxes that pile up.
template <class real>
void expect_momentum_is_summed(InitialState<real> state, double rounding) {
  state = summed(std::move(state));
  state.params.substeps = 3;
  ReferenceBackend<real> backend(state);
  step(backend, state.params);
  for (int i = 0; i < 20; ++i) {
    const std::vector<Motion<real>> before = backend.buffers().motions;
    step(backend, state.params);
    const Buffers<real>& b = backend.buffers();
    ASSERT_EQ(b.counters[COUNTER_STATUS], 0u);
    std::vector<Vector3> pushes(b.body_infos.size() + 1, Vector3{0, 0, 0});
    for (u32 k = 0; k < b.counters[COUNTER_CONTACTS]; ++k) {
      const u32 row = b.contact_slots[k] / PACK, lane = b.contact_slots[k] % PACK;
      const ImpulseSumBlock<real>& sum = b.impulse_sums[row];
      const Vector3 impulse = {double(sum.x[lane]), double(sum.y[lane]), double(sum.z[lane])};
      for (u32 axis = 0; axis < 3; ++axis) {
        pushes[b.contacts[k].body_a][axis] += impulse[axis];
        pushes[b.contacts[k].body_b][axis] -= impulse[axis];
      }
    }
    for (u32 body = 0; body < b.body_infos.size(); ++body) {
      if (b.body_infos[body].kind != BODY_DYNAMIC) continue;
      const double mass = double(b.masses[body].mass), time = 3 * double(state.params.dt);
      const Vec4<real>& g = b.gravities[0];
      const Vector3 weight = {double(g.x) * time, double(g.y) * time, double(g.z) * time};
      for (u32 axis = 0; axis < 3; ++axis)
        ASSERT_NEAR(mass * (double(b.motions[body].v[axis] - before[body].v[axis]) - weight[axis]), pushes[body][axis],
                    rounding)
            << "step " << i << ", body " << body << ", axis " << axis;
    }
  }
}

TYPED_TEST(SumImpulses, AreTheMomentumThatBodiesGet) {
  using real = TypeParam;
  const double rounding = sizeof(real) == 4 ? 1e-4 : 1e-13;
  expect_momentum_is_summed(heap<real>(5, 60, 4096), rounding);
  InitialState<real> jacobi = heap<real>(6, 60, 4096);
  use_jacobi(jacobi);
  expect_momentum_is_summed(jacobi, rounding);
  InitialState<real> patches = heap<real>(7, 60, 4096);
  use_patches(patches);
  expect_momentum_is_summed(patches, rounding);
  InitialState<real> soft = heap<real>(8, 60, 4096);
  soft.features = with(soft.features, Feature::soft_contacts);
  resize(soft.buffers, soft.sizes, soft.features);
  soft.params.softness = real(0.3);
  expect_momentum_is_summed(soft, rounding);
}

// Of a step of one sub-step they are what is kept for the next step.
TYPED_TEST(SumImpulses, OfOneSubStepAreItsImpulses) {
  using real = TypeParam;
  const double rounding = sizeof(real) == 4 ? 1e-6 : 1e-15;
  const InitialState<real> state = summed(heap<real>(9, 40, 4096));
  ReferenceBackend<real> backend(state);
  for (int i = 0; i < 5; ++i) step(backend, state.params);
  const Buffers<real>& b = backend.buffers();
  ASSERT_GT(b.counters[COUNTER_CONTACTS], 40u);
  for (u32 k = 0; k < b.counters[COUNTER_CONTACTS]; ++k) {
    const u32 row = b.contact_slots[k] / PACK, lane = b.contact_slots[k] % PACK;
    const ContactBlock<real>& c = b.contact_blocks[row];
    const ContactImpulse<real>& kept = b.cached_impulses[k];
    EXPECT_NEAR(double(b.impulse_sums[row].x[lane]), double(kept.normal * c.normal_x[lane] + kept.tangent_x), rounding);
    EXPECT_NEAR(double(b.impulse_sums[row].z[lane]), double(kept.normal * c.normal_z[lane] + kept.tangent_z), rounding);
  }
}

// A scene that nobody asks for its forces pays nothing.
TYPED_TEST(SumImpulses, AreMadeWhereTheyAreAskedForAlone) {
  using real = TypeParam;
  Scene scene = random_joints(4, 10, 20);
  const auto sums = [&](Forces forces, std::optional<double> impact_speed) {
    scene.settings.forces = forces;
    scene.settings.impact_speed = impact_speed;
    const InitialState<real> state = compile<real>(scene);
    EXPECT_EQ(runs(Stage::sum_impulses, state.features), !state.buffers.joint_sums.empty());
    EXPECT_TRUE(state.buffers.impulse_sums.empty()) << "nothing can touch";
    return runs(Stage::sum_impulses, state.features);
  };
  EXPECT_FALSE(sums(Forces::automatic, {}));
  EXPECT_FALSE(sums(Forces::substep, {}));
  EXPECT_FALSE(sums(Forces::substep, 1.0));
  EXPECT_TRUE(sums(Forces::step, {}));
  EXPECT_TRUE(sums(Forces::automatic, 1.0));
  scene.joints.clear();
  scene.settings.forces = Forces::step;
  EXPECT_FALSE(runs(Stage::sum_impulses, compile<real>(scene).features)) << "nothing pushes";
}

TYPED_TEST(SumImpulses, AbortedStepsAddNothing) {
  using real = TypeParam;
  InitialState<real> state = summed(pair_of_spheres<real>());
  state.buffers.impulse_sums[0].x[0] = 7;
  state.params.substep = 1;
  state.buffers.counters[COUNTER_STATUS] = STATUS_BLOCKS_FULL;
  EXPECT_EQ(run_twins(Stage::sum_impulses, state).impulse_sums[0].x[0], 7);
}

}  // namespace
}  // namespace lockstep::test::sum_impulses_test
