#include <gtest/gtest.h>

#include <cmath>

#include "tests/event_worlds.hpp"

namespace lockstep::test::mark_touching_test {
namespace {

template <class real>
class MarkTouching : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(MarkTouching, Precisions);

const auto before_marking = {
    Stage::update_bounds,        Stage::sort_cells,       Stage::find_pairs,    Stage::collide,
    Stage::match_contacts,       Stage::color_contacts,   Stage::pack_contacts, Stage::pack_points,
    Stage::integrate_velocities, Stage::prepare_contacts, Stage::warm_start,    Stage::solve_constraints,
    Stage::integrate_positions};

// An impulse, or an overlap: in double, by the centres and radii of spheres that do not turn.
TYPED_TEST(MarkTouching, WhatPushesOrOverlapsTouches) {
  using real = TypeParam;
  std::vector<BodyDescription> bodies;
  Random random(60);
  for (u32 n = 0; n < 300; ++n)
    bodies.push_back(sphere_body(random.vector(2), random.between(0.1, 0.3), random.vector(8)));
  InitialState<real> state = make_event_worlds<real>({bodies}, 20000);
  run_reference(state, before_marking);
  Buffers<real>& b = state.buffers;
  reference::run_stage(Stage::mark_touching, b, state.params);
  u32 pushing = 0, overlapping = 0, separated = 0;
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    const Contact& contact = b.contacts[i];
    double square = 0;
    const Vec4<real>&p = b.positions[contact.body_a], &q = b.positions[contact.body_b];
    for (const double d : {double(p.x) - q.x, double(p.y) - q.y, double(p.z) - q.z}) square += d * d;
    const double gap = std::sqrt(square) - b.shapes[contact.shape_a].size[0] - b.shapes[contact.shape_b].size[0];
    const real impulse = b.impulse_blocks[b.contact_slots[i] / PACK].normal[b.contact_slots[i] % PACK];
    if (std::abs(gap) < 1e-6 && !(impulse > 0)) continue;
    EXPECT_EQ(b.touched[i], impulse > 0 || gap < 0 ? 1u : 0u);
    pushing += impulse > 0 && gap > 0 ? 1 : 0;
    overlapping += !(impulse > 0) && gap < 0 ? 1 : 0;
    separated += b.touched[i] == 0 ? 1 : 0;
  }
  EXPECT_GT(pushing, 5u);
  EXPECT_GT(overlapping, 5u);
  EXPECT_GT(separated, 5u);
}

TYPED_TEST(MarkTouching, LaterSubStepsForgetNothing) {
  using real = TypeParam;
  InitialState<real> state =
      make_event_worlds<real>({{sphere_body({0, 0, 0}, 1), sphere_body({2.001, 0, 0}, 1, {1, 0, 0})}}, 16);
  run_reference(state, before_marking);
  ASSERT_EQ(state.buffers.counters[COUNTER_CONTACTS], 1u);
  state.buffers.touched[0] = 1;
  reference::run_stage(Stage::mark_touching, state.buffers, state.params);
  EXPECT_EQ(state.buffers.touched[0], 0u);  // the first sub-step starts anew
  state.buffers.touched[0] = 1;
  state.params.substep = 1;
  reference::run_stage(Stage::mark_touching, state.buffers, state.params);
  EXPECT_EQ(state.buffers.touched[0], 1u);
}

template <class real>
InitialState<real> with_impacts(InitialState<real> state) {
  state.features = with(state.features, Feature::impacts);
  resize(state.buffers, state.sizes, state.features);
  return state;
}

// What pushes came together at the velocities of the start, along the normal: spheres that do not turn.
TYPED_TEST(MarkTouching, TellsHowFastWhatPushesCameTogether) {
  using real = TypeParam;
  std::vector<BodyDescription> bodies;
  Random random(61);
  for (u32 n = 0; n < 300; ++n)
    bodies.push_back(sphere_body(random.vector(2), random.between(0.1, 0.3), random.vector(8)));
  InitialState<real> state = with_impacts(make_event_worlds<real>({bodies}, 20000));
  run_reference(state, before_marking);
  Buffers<real>& b = state.buffers;
  reference::run_stage(Stage::mark_touching, b, state.params);
  u32 fast = 0, separated = 0;
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    const Contact& contact = b.contacts[i];
    const Vec4<real>&p = b.positions[contact.body_a], &q = b.positions[contact.body_b];
    const Vector3 offset_ab = {double(p.x) - q.x, double(p.y) - q.y, double(p.z) - q.z};
    const Vector3& of_a = bodies[contact.body_a].velocity;
    const Vector3& of_b = bodies[contact.body_b].velocity;
    const double speed = exact::dot(exact::unit(offset_ab), exact::subtract(of_b, of_a));
    const bool pushes = b.impulse_blocks[b.contact_slots[i] / PACK].normal[b.contact_slots[i] % PACK] > 0;
    EXPECT_NEAR(b.impact_speeds[i], pushes ? std::max(speed, 0.0) : 0, 1e-4);
    fast += pushes && speed > 1 ? 1 : 0;
    separated += pushes ? 0 : 1;
  }
  EXPECT_GT(fast, 5u);
  EXPECT_GT(separated, 5u);

  // the fastest of all sub-steps
  b.impact_speeds[0] = 77;
  state.params.substep = 1;
  reference::run_stage(Stage::mark_touching, b, state.params);
  EXPECT_EQ(b.impact_speeds[0], 77);
}

// A blow is told where it begins: not where the contact pushed in the sub-step before, or at the end of the last step.
TYPED_TEST(MarkTouching, WhatGoesOnToPushIsNoImpact) {
  using real = TypeParam;
  InitialState<real> state = with_impacts(
      make_event_worlds<real>({{sphere_body({0, 0, 0}, 1), sphere_body({2.001, 0, 0}, 1, {-3, 0, 0})}}, 16));
  run_reference(state, before_marking);
  Buffers<real>& b = state.buffers;
  ASSERT_EQ(b.counters[COUNTER_CONTACTS], 1u);
  const auto speed_of = [&](u32 substep) {
    state.params.substep = substep;
    b.impact_speeds[0] = 0;
    reference::run_stage(Stage::mark_touching, b, state.params);
    EXPECT_NE(b.touched[0], 0u);
    return double(b.impact_speeds[0]);
  };
  EXPECT_NEAR(speed_of(0), 3, 1e-6);
  EXPECT_EQ(speed_of(1), 0) << "it pushed in sub-step 0";
  b.touched[0] = 1;
  EXPECT_NEAR(speed_of(1), 3, 1e-6);
  b.start_impulses[0].normal = 1;
  EXPECT_EQ(speed_of(0), 0) << "it pushed in the last step";
}

TYPED_TEST(MarkTouching, KernelMatchesReferenceWithImpacts) {
  using real = TypeParam;
  InitialState<real> state = with_impacts(make_event_worlds<real>(lively_worlds(), 100000));
  expect_kernel_matches(Stage::mark_touching, state, before_marking);
  state.params.substep = 2;
  expect_kernel_matches(Stage::mark_touching, state, before_marking);
}

TYPED_TEST(MarkTouching, KernelMatchesReference) {
  using real = TypeParam;
  InitialState<real> state = make_event_worlds<real>(lively_worlds(), 100000);
  expect_kernel_matches(Stage::mark_touching, state, before_marking);
  state.params.substep = 2;
  expect_kernel_matches(Stage::mark_touching, state, before_marking);
}

}  // namespace
}  // namespace lockstep::test::mark_touching_test
