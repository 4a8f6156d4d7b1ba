#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "tests/collision_states.hpp"

namespace lockstep::test::collide_test {
namespace {

template <class real>
class Collide : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Collide, Precisions);

template <class real>
void find_contacts(InitialState<real>& state) {
  run_reference(state, {Stage::update_bounds, Stage::sort_cells, Stage::find_pairs, Stage::collide});
}

std::vector<std::vector<BodyDescription>> heaps(u32 count) {
  std::vector<std::vector<BodyDescription>> worlds;
  for (u32 w = 0; w < count; ++w) {
    Random random(20 + w);
    worlds.push_back({plane_body({0, 0, -1})});
    for (u32 n = 0; n < 100 + 100 * w; ++n)
      worlds.back().push_back(sphere_body(random.vector(2), random.between(0.1, 0.4), random.vector(2)));
  }
  return worlds;
}

// Every two spheres, and every sphere and plane, whose gap would be closed up to the margin after a step at their
// present speed along the normal: in double by closed form, apart from ties.
TYPED_TEST(Collide, KeepsWhatTouchesWithinTheStep) {
  using real = TypeParam;
  InitialState<real> state = make_worlds<real>(heaps(1), 20000);
  find_contacts(state);
  const Buffers<real>& b = state.buffers;
  const u32 shapes = state.sizes.shapes;
  std::vector<u32> contact(shapes * shapes, 0);
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i)
    ++contact[b.contacts[i].shape_a * shapes + b.contacts[i].shape_b];
  u32 kept = 0;
  for (u32 i = 1; i < shapes; ++i) {
    for (u32 j = 0; j < shapes; ++j) {
      if (j > 0 && j <= i) continue;  // shape 0 is the plane
      double gap = double(b.positions[i].z) + 1 - double(b.shapes[i].size[0]), speed = -double(b.motions[i].v[2]);
      if (j > 0) {
        const double d[3] = {double(b.positions[i].x) - b.positions[j].x, double(b.positions[i].y) - b.positions[j].y,
                             double(b.positions[i].z) - b.positions[j].z};
        const double distance = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        gap = distance - b.shapes[i].size[0] - b.shapes[j].size[0];
        speed = 0;
        for (int k = 0; k < 3; ++k) speed -= (double(b.motions[i].v[k]) - b.motions[j].v[k]) * d[k] / distance;
      }
      const double open = gap - std::max(speed, 0.0) * state.params.dt - state.params.margin;
      if (std::abs(open) < 1e-5) continue;
      EXPECT_EQ(contact[i * shapes + j], open < 0 ? 1u : 0u) << i << " " << j << " open by " << open;
      kept += open < 0 ? 1 : 0;
    }
  }
  EXPECT_GT(kept, 30u);
}

TYPED_TEST(Collide, OrdersAndNumbersTheContactsOfEachWorld) {
  using real = TypeParam;
  std::vector<std::vector<BodyDescription>> worlds = heaps(4);
  worlds.insert(worlds.begin() + 2, {sphere_body({0, 0, 0}, 1)});  // a world without contacts
  InitialState<real> state = make_worlds<real>(worlds, 20000);
  find_contacts(state);
  const Buffers<real>& b = state.buffers;
  EXPECT_EQ(b.counters[COUNTER_STATUS], 0u);
  EXPECT_EQ(b.counters[COUNTER_CONTACTS], b.counters[COUNTER_CONTACTS_NEEDED]);
  ASSERT_GT(b.counters[COUNTER_CONTACTS], 300u);
  u32 rank = 0;
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    const Contact& contact = b.contacts[i];
    rank = i > 0 && contact.world == b.contacts[i - 1].world ? rank + 1 : 0;
    EXPECT_EQ(contact.rank, rank);
    EXPECT_EQ(contact.feature, 0u);
    EXPECT_EQ(contact.body_a, b.shape_infos[contact.shape_a].body);
    EXPECT_EQ(contact.body_b, b.shape_infos[contact.shape_b].body);
    EXPECT_EQ(contact.world, b.body_infos[contact.body_a].world);
    EXPECT_EQ(contact.world, b.body_infos[contact.body_b].world);
    EXPECT_EQ(b.shape_infos[contact.shape_a].kind, u32(SHAPE_SPHERE));
    if (i == 0) continue;
    const Contact& last = b.contacts[i - 1];
    EXPECT_LT(std::pair(last.shape_a, last.shape_b), std::pair(contact.shape_a, contact.shape_b));
  }
}

// At rest on the ground a sphere has one contact; passing by at the side it has none, however fast.
TYPED_TEST(Collide, TangentialSpeedMakesNoContact) {
  using real = TypeParam;
  InitialState<real> state =
      make_worlds<real>({{plane_body(), sphere_body({0, 0, 0.5}, 0.5), sphere_body({5, 0, 0.75}, 0.5, {500, 0, 0}),
                          sphere_body({5, 3, 0.75}, 0.5, {0, 0, 500}), sphere_body({5, 6, 0.75}, 0.5, {0, 0, -500})}},
                        100);
  find_contacts(state);
  ASSERT_EQ(state.buffers.counters[COUNTER_CONTACTS], 2u);
  EXPECT_EQ(state.buffers.contacts[0].shape_a, 1u);
  EXPECT_EQ(state.buffers.contacts[1].shape_a, 4u);
}

// A turntable tilts towards a sphere: the plane's own motion counts, at the point of touch.
TYPED_TEST(Collide, AMovingPlaneMeetsTheSphere) {
  using real = TypeParam;
  for (const double rate : {0.0, 1.0, -1.0}) {
    BodyDescription table = plane_body();
    table.kind = BODY_KINEMATIC;
    table.angular_velocity = {0, -rate, 0};  // raises the side of positive x
    InitialState<real> state = make_worlds<real>({{table, sphere_body({10, 0, 1}, 0.5)}}, 100);
    state.params.dt = real(1) / 16;  // the table rises 10/16 m under the sphere
    find_contacts(state);
    EXPECT_EQ(state.buffers.counters[COUNTER_CONTACTS], rate > 0 ? 1u : 0u);
  }
}

TYPED_TEST(Collide, TooLittleRoomVoidsTheStep) {
  using real = TypeParam;
  InitialState<real> state = make_worlds<real>({std::vector<BodyDescription>(20, sphere_body({3, 3, 3}, 0.5))}, 190);
  state.params.contact_capacity = 100;
  state.buffers.contacts.assign(190, {7, 7, 7, 7, 7, 7, 7, 7});
  find_contacts(state);
  EXPECT_EQ(state.buffers.counters[COUNTER_STATUS], u32(STATUS_CONTACTS_FULL));
  EXPECT_EQ(state.buffers.counters[COUNTER_CONTACTS], 0u);
  EXPECT_EQ(state.buffers.counters[COUNTER_CONTACTS_NEEDED], 190u);
  for (u32 i = 100; i < 190; ++i) EXPECT_EQ(state.buffers.contacts[i].shape_a, 7u);

  state.params.pair_capacity = 100;  // a step without pairs has no contacts either
  find_contacts(state);
  EXPECT_EQ(state.buffers.counters[COUNTER_STATUS], u32(STATUS_PAIRS_FULL));
  EXPECT_EQ(state.buffers.counters[COUNTER_CONTACTS], 0u);
}

TYPED_TEST(Collide, KernelMatchesReference) {
  using real = TypeParam;
  const auto before = {Stage::update_bounds, Stage::sort_cells, Stage::find_pairs};
  InitialState<real> state = make_worlds<real>(lively_worlds(), 100000);
  const Buffers<real> after = expect_kernel_matches(Stage::collide, state, before);
  EXPECT_GT(after.counters[COUNTER_CONTACTS], 1000u);
  state.params.contact_capacity = state.sizes.contacts = after.counters[COUNTER_CONTACTS] - 1;
  expect_kernel_matches(Stage::collide, state, before);
  state.params.pair_capacity = state.sizes.pairs = 10;
  const Buffers<real> full = expect_kernel_matches(Stage::collide, state, before);
  EXPECT_EQ(full.counters[COUNTER_STATUS], u32(STATUS_PAIRS_FULL));
}

TYPED_TEST(Collide, KernelMatchesReferenceForAllShapes) {
  using real = TypeParam;
  const auto before = {Stage::update_bounds, Stage::sort_cells, Stage::find_pairs};
  const InitialState<real> state = make_worlds<real>(worlds_of_pairs(3000), 20000);
  InitialState<real> found = state;
  run_reference(found, before);
  const Buffers<real> after = run_one_stage(Stage::collide, found.buffers, found.sizes, found.features, found.params,
                                            launches_of_a_step<real>());
  EXPECT_GT(after.counters[COUNTER_CONTACTS], 2000u);
  for (u32 i = 1; i < after.counters[COUNTER_CONTACTS]; ++i) {
    const Contact &last = after.contacts[i - 1], &contact = after.contacts[i];
    EXPECT_LT(std::tuple(last.shape_a, last.shape_b, last.feature),
              std::tuple(contact.shape_a, contact.shape_b, contact.feature));
  }
}

// The points of a box at rest are the same ones in every step.
TYPED_TEST(Collide, ARestingBoxKeepsItsFourContacts) {
  using real = TypeParam;
  BodyDescription table = box_body({0, 0, -1}, {2, 2, 1});
  table.kind = BODY_STATIC;
  for (const double angle : {0.0, 0.3, 0.785}) {
    const double c = std::cos(angle / 2), s = std::sin(angle / 2);
    InitialState<real> state =
        make_worlds<real>({{table, box_body({0.3, 0.2, 0.5}, {0.5, 0.3, 0.5}, {0, 0, s, c})}}, 64);
    ReferenceBackend<real> backend(state);
    std::vector<u32> features;
    for (int n = 0; n < 1000; ++n) {
      step(backend, state.params);
      const Buffers<real>& b = backend.buffers();
      ASSERT_EQ(b.counters[COUNTER_CONTACTS], 4u) << "step " << n << ", angle " << angle;
      std::vector<u32> current;
      for (u32 i = 0; i < 4; ++i) current.push_back(b.contacts[i].feature);
      if (n == 0) features = current;
      ASSERT_EQ(current, features) << "step " << n << ", angle " << angle;
    }
  }
}

// A cylinder rolls along the ground on its side: it touches along its whole line in every step, and neither friction
// nor correction takes its speed.
TYPED_TEST(Collide, ARollingCylinderNeverLosesContact) {
  using real = TypeParam;
  const double radius = 0.3, half_length = 0.5, h = std::sqrt(0.5);
  for (const bool on_box : {false, true}) {
    BodyDescription ground = on_box ? box_body({0, 0, -1}, {20, 20, 1}) : plane_body();
    ground.kind = BODY_STATIC;
    BodyDescription roller = round_body(SHAPE_CYLINDER, {-5, 0, radius}, radius, half_length, {h, 0, 0, h});
    roller.velocity = {1, 0, 0};
    roller.angular_velocity = {0, 1 / radius, 0};
    InitialState<real> state = make_worlds<real>({{ground, roller}}, 64);
    state.params.dt = real(1) / 240;
    ReferenceBackend<real> backend(state);
    for (int n = 0; n < 1000; ++n) {
      step(backend, state.params);
      const Buffers<real>& b = backend.buffers();
      ASSERT_GE(b.counters[COUNTER_CONTACTS], 2u) << "step " << n << (on_box ? " on a box" : "");
      double least = 1, most = -1;
      for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
        const real y = b.contact_points[i].anchor_a[2];
        const real other = b.contact_points[i].anchor_b[2];
        const double along = double(b.contacts[i].body_a == 1 ? y : other);
        least = std::min(least, along);
        most = std::max(most, along);
      }
      ASSERT_NEAR(most - least, 2 * half_length, 0.02) << "step " << n << (on_box ? " on a box" : "");
    }
    EXPECT_NEAR(double(backend.buffers().motions[1].v[0]), 1, 2e-3) << (on_box ? "on a box" : "");
    EXPECT_NEAR(double(backend.buffers().positions[1].x), -5 + 1000.0 / 240, 5e-3) << (on_box ? "on a box" : "");
  }
}

}  // namespace
}  // namespace lockstep::test::collide_test
