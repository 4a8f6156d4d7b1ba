#include <gtest/gtest.h>

#include <cmath>

#include "tests/contact_scene.hpp"

namespace lockstep::test::prepare_contacts_test {
namespace {

template <class real>
class PrepareContacts : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(PrepareContacts, Precisions);

template <class real>
constexpr double tolerance = sizeof(real) == 4 ? 2e-6 : 1e-14;

// A sphere of 1 m over the ground, `gap` above it, falling at `speed`; no gravity.
template <class real>
InitialState<real> sphere_over_ground(double gap, double speed, double restitution) {
  InitialState<real> state = make_worlds<real>({{sphere_body({0, 0, 1 + gap}, 1, {0, 0, -speed}), plane_body()}}, 16);
  state.buffers.gravities[0] = {0, 0, 0, 0};
  state.params.margin = 1;
  state.params.theta = 1;
  set_material(state, 0.5, restitution);
  return state;
}

template <class real>
double bias_of(InitialState<real> state) {
  run_until_prepared(state);
  EXPECT_EQ(state.buffers.counters[COUNTER_CONTACTS], 1u);
  return double(state.buffers.contact_blocks[0].bias[0]);
}

// A pile with all kinds of contacts: central and general, dynamic, static and kinematic, shallow and deep.
template <class real>
InitialState<real> mixed_pile() {
  Random random(21);
  std::vector<BodyDescription> bodies = {plane_body(), plane_body({0, 0, 0}, {0.1, 0, 0, std::sqrt(0.99)})};
  for (int i = 0; i < 60; ++i) {
    BodyDescription body =
        sphere_body({random.between(-2, 2), random.between(-2, 2), random.between(0.4, 1.2)}, 0.5, random.vector(1));
    body.angular_velocity = random.vector(2);
    if (i % 3 == 1) body.inertia = {0.1, 0.12, 0.05};
    if (i % 3 == 2) body.shapes[0].offset = {0.1, 0, -0.2};
    if (i % 10 == 9) body.kind = BODY_KINEMATIC;
    bodies.push_back(body);
  }
  InitialState<real> state = make_worlds<real>({bodies}, 4096);
  set_material(state, 0.4, 0.3);
  state.params.theta = real(0.5);
  return state;
}

TYPED_TEST(PrepareContacts, KernelMatchesReference) {
  using real = TypeParam;
  InitialState<real> state = mixed_pile<real>();
  run_until_prepared(state);
  ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], 100u);
  Random random(22);
  for (auto& start : state.buffers.start_impulses)
    start = {real(random.between(-0.2, 1)), real(random.between(-1, 1)), real(random.between(-1, 1)), 0};
  reference::run_stage(Stage::pack_points, state.buffers, state.params);
  run_twins(Stage::prepare_contacts, state);
  state.params.substep = 1;  // impulses from the blocks
  run_twins(Stage::prepare_contacts, state);
}

// The pile with laws, friction and restitution at random, some of it central, in bodies split into copies and soft too.
template <class real>
InitialState<real> pile_of_laws(Feature further, real softness) {
  InitialState<real> state = mixed_pile<real>();
  state.features = with(with(state.features, Feature::impact_laws), further);
  state.params.softness = softness;
  resize(state.buffers, state.sizes, state.features);
  run_until_prepared(state);
  Random random(31);
  Buffers<real>& b = state.buffers;
  for (u32 row = 0; row < b.counters[COUNTER_ROWS]; ++row) {
    for (u32 lane = 0; lane < PACK; ++lane) {
      b.impact_blocks[row].law[lane] = random.bits() % IMPACT_LAWS;
      b.impact_blocks[row].tangential_restitution[lane] = real(random.between(-1, 1));
      b.point_blocks[row].restitution[lane] = random.bits() % 4 == 0 ? real(0) : real(random.between(0, 1));
      b.point_blocks[row].friction[lane] = random.bits() % 6 == 0 ? real(0) : real(random.between(0, 1.5));
    }
  }
  for (Velocity<real>& v : b.previous_velocities) {  // fast enough for blows
    for (real& x : v.v) x *= 3;
    for (real& x : v.w) x *= 3;
  }
  for (Motion<real>& m : b.motions) {
    for (real& x : m.v) x *= 3;
    for (real& x : m.w) x *= 3;
  }
  return state;
}

TYPED_TEST(PrepareContacts, LawsOfImpactMatchTheReference) {
  using real = TypeParam;
  for (const auto& [further, softness] :
       {std::pair{Feature::always, 0.0}, {Feature::jacobi, 0.0}, {Feature::soft_contacts, 0.3}}) {
    InitialState<real> state = pile_of_laws<real>(further, real(softness));
    run_twins(Stage::prepare_contacts, state);
    reference::run_stage(Stage::prepare_contacts, state.buffers, state.params);
    u32 slides = 0;
    for (u32 row = 0; row < state.buffers.counters[COUNTER_ROWS]; ++row)
      for (u32 lane = 0; lane < PACK; ++lane) slides += state.buffers.slide_blocks[row].bias_1[lane] != 0 ? 1u : 0u;
    EXPECT_GT(slides, 20u);
  }
}

// The first step after a blow: what rests is not hit, what closes slowly bounces by Newton's law, what is hit gets the
// outcome of its law.
TYPED_TEST(PrepareContacts, LawsOfImpactActOnBlows) {
  using real = TypeParam;
  const auto slide_of = [](double gap, double speed, double drag) {
    InitialState<real> state = sphere_over_ground<real>(gap, speed, 1);
    state.features = with(state.features, Feature::impact_laws);
    resize(state.buffers, state.sizes, state.features);
    state.buffers.impact_pairs[0] = {1, IMPACT_CHATTERJEE_RUINA, 0};
    state.buffers.gravities[0] = {0, 0, real(-drag), 0};
    state.buffers.motions[0].v[0] = real(0.25);
    run_until_prepared(state);
    return std::pair{double(state.buffers.contact_blocks[0].bias[0]), double(state.buffers.slide_blocks[0].bias_1[0])};
  };
  const auto [bias, slide] = slide_of(0, 2, 0);
  EXPECT_NEAR(bias, -2, tolerance<real>);
  EXPECT_NEAR(slide, 0.25, tolerance<real>);                      // the slip turns round, to -0.25
  const auto [still_bias, still_slide] = slide_of(0, 0.1, 9.81);  // 9.81 / 60 m/s are more than 0.1
  EXPECT_NEAR(still_bias, -0.1, tolerance<real>);
  EXPECT_EQ(still_slide, 0);
  const auto [heavy_bias, heavy_slide] = slide_of(0, 2, 9.81);  // forces of the sub-step do not bounce
  EXPECT_NEAR(heavy_bias, -2, 2 * tolerance<real>);
  EXPECT_NEAR(heavy_slide, 0.25, tolerance<real>);
  const auto [far_bias, far_slide] = slide_of(0.1, 2, 0);  // not in this step
  EXPECT_NEAR(far_bias, 6, 1e-4);
  EXPECT_EQ(far_slide, 0);
}

TYPED_TEST(PrepareContacts, DelassusBlockOfASphere) {
  using real = TypeParam;
  // on an immovable plane: w_nn = 1/m, w_tt = 1/m + r^2 / (2/5 m r^2) = 3.5/m
  InitialState<real> state = sphere_over_ground<real>(0, 0, 0);
  run_until_prepared(state);
  const auto& ground = state.buffers.contact_blocks[0];
  EXPECT_NEAR(double(ground.w_nn[0]), 1, tolerance<real>);
  EXPECT_NEAR(double(ground.w_11[0]), 3.5, tolerance<real>);
  EXPECT_NEAR(double(ground.w_22[0]), 3.5, tolerance<real>);
  EXPECT_EQ(state.buffers.block_bodies[0].kind[0], u32{BLOCK_CENTRAL});

  // two spheres of different radii: both sides add
  InitialState<real> two = make_worlds<real>({{sphere_body({0, 0, 0}, 1), sphere_body({0.9, 1.2, 0}, 0.5)}}, 16);
  run_until_prepared(two);
  const auto& pair = two.buffers.contact_blocks[0];
  EXPECT_NEAR(double(pair.normal_x[0]), -0.6, tolerance<real>);
  EXPECT_NEAR(double(pair.normal_y[0]), -0.8, tolerance<real>);
  EXPECT_NEAR(double(pair.w_nn[0]), 2, tolerance<real>);
  EXPECT_NEAR(double(pair.w_11[0]), 7, 10 * tolerance<real>);
}

// W is what the law says: column j is the velocity at the contact that a unit impulse along axis j gives to bodies at
// rest.
TYPED_TEST(PrepareContacts, DelassusBlockIsTheAnswerToUnitImpulses) {
  using real = TypeParam;
  InitialState<real> state = mixed_pile<real>();
  run_until_prepared(state);
  Buffers<real>& b = state.buffers;
  u32 general = 0;
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    const u32 lane = b.contact_slots[i] % PACK;
    const ContactBlock<real>& c = b.contact_blocks[b.contact_slots[i] / PACK];
    const Contact& contact = b.contacts[i];
    const bool central = reference::is_central(b, contact.body_a, contact.shape_a) &&
                         reference::is_central(b, contact.body_b, contact.shape_b);
    general += central ? 0u : 1u;
    const Vector3 n = {c.normal_x[lane], c.normal_y[lane], c.normal_z[lane]};
    const double sign = n[2] < 0 ? -1 : 1, k = -1 / (sign + n[2]);
    const Vector3 axes[3] = {n,
                             {1 + sign * n[0] * n[0] * k, sign * n[0] * n[1] * k, -sign * n[0]},
                             {n[0] * n[1] * k, sign + n[1] * n[1] * k, -n[1]}};
    const auto cross = [](const Vector3& x, const Vector3& y) -> Vector3 {
      return {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
    };
    const auto dot = [](const Vector3& x, const Vector3& y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
    const auto velocity_per_impulse = [&](u32 body, const Vector3& arm, const Vector3& axis) -> Vector3 {
      const Motion<real>& m = b.motions[body];
      const Vector3 h = cross(arm, axis);
      const double xx = m.inertia_xx, yy = m.inertia_yy, zz = m.inertia_zz;
      const double xy = m.inertia_xy, xz = m.inertia_xz, yz = m.inertia_yz;
      const Vector3 w = {xx * h[0] + xy * h[1] + xz * h[2], xy * h[0] + yy * h[1] + yz * h[2],
                         xz * h[0] + yz * h[1] + zz * h[2]};
      Vector3 v = cross(w, arm);
      for (int d = 0; d < 3; ++d) v[d] += double(m.inverse_mass) * axis[d];
      return v;
    };
    const Vector3 arm_a = {c.arm_a_x[lane], c.arm_a_y[lane], c.arm_a_z[lane]};
    const Vector3 arm_b = {c.arm_b_x[lane], c.arm_b_y[lane], c.arm_b_z[lane]};
    const double w[3][3] = {{c.w_nn[lane], c.w_n1[lane], c.w_n2[lane]},
                            {c.w_n1[lane], c.w_11[lane], c.w_12[lane]},
                            {c.w_n2[lane], c.w_12[lane], c.w_22[lane]}};
    for (int column = 0; column < 3; ++column) {
      const Vector3 va = velocity_per_impulse(contact.body_a, arm_a, axes[column]);
      const Vector3 vb = velocity_per_impulse(contact.body_b, arm_b, axes[column]);
      for (int row = 0; row < 3; ++row)
        EXPECT_NEAR(dot(axes[row], va) + dot(axes[row], vb), w[row][column], 20 * tolerance<real> * w[0][0])
            << "contact " << i << ", " << row << column;
    }
  }
  EXPECT_GT(general, 50u);
}

TYPED_TEST(PrepareContacts, BiasLetsAnOpenGapClose) {
  using real = TypeParam;
  InitialState<real> state = sphere_over_ground<real>(0.01, 2, 0);
  EXPECT_NEAR(bias_of(state), 0.01 * 60, 200 * tolerance<real>);  // u_n >= -gap / dt
  state.params.theta = real(0.5);                                 // half of the old velocity moves the bodies as well
  EXPECT_NEAR(bias_of(state), 0, tolerance<real>);                // it has closed the gap already: no negative bias
  state.buffers.motions[0].v[2] = real(-0.2);
  EXPECT_NEAR(bias_of(state), (0.01 * 60 - 0.5 * 0.2) / 0.5, 400 * tolerance<real>);
  state.params.theta = 0;  // bodies move with the old velocity: the next step's gap is what counts
  EXPECT_NEAR(bias_of(state), 0.01 * 60 - 0.2, 200 * tolerance<real>);
}

TYPED_TEST(PrepareContacts, BiasSeparatesOverlaps) {
  using real = TypeParam;
  InitialState<real> state = sphere_over_ground<real>(-0.01, 0, 0);
  EXPECT_NEAR(bias_of(state), -0.2 * (0.01 - 1e-4) * 60, 200 * tolerance<real>);
  state.params.slop = real(0.02);
  EXPECT_EQ(bias_of(state), 0);
  state.params.slop = 0;
  state.params.correction_limit = real(0.05);
  EXPECT_NEAR(bias_of(state), -0.05, tolerance<real>);
}

TYPED_TEST(PrepareContacts, BiasBouncesWhatArrivesFastEnough) {
  using real = TypeParam;
  InitialState<real> state = sphere_over_ground<real>(0.01, 2, 0.5);
  EXPECT_NEAR(bias_of(state), -1, tolerance<real>);  // closes in this step: leaves at e u
  state.params.restitution_threshold = 3;
  EXPECT_NEAR(bias_of(state), 0.01 * 60, 200 * tolerance<real>);
  state = sphere_over_ground<real>(0.1, 2, 0.5);  // 2/60 m of way: not in this step
  EXPECT_NEAR(bias_of(state), 0.1 * 60, 200 * tolerance<real>);
  state = sphere_over_ground<real>(-0.1, 0.5, 0.5);  // deep: pushed out faster than it would bounce
  EXPECT_NEAR(bias_of(state), -0.2 * (0.1 - 1e-4) * 60, 200 * tolerance<real>);
}

// What parts may come to close at e times its speed (Moreau's law), unless it is pushed apart faster than it parts, or
// is soft.
TYPED_TEST(PrepareContacts, BiasLetsCloseWhatSeparates) {
  using real = TypeParam;
  InitialState<real> state = sphere_over_ground<real>(0, -2, 0.5);
  EXPECT_NEAR(bias_of(state), 1, tolerance<real>);
  state.params.restitution_threshold = 3;
  EXPECT_EQ(bias_of(state), 0);
  state.params.restitution_threshold = 0;
  state.params.softness = real(0.1);
  EXPECT_EQ(bias_of(state), 0);
  state = sphere_over_ground<real>(0.01, -2, 0.5);
  EXPECT_NEAR(bias_of(state), 1, tolerance<real>);    // more than 0.01 * 60
  state = sphere_over_ground<real>(-0.1, -0.5, 0.5);  // deep: pushed out at 0.2 * 0.1 * 60
  EXPECT_NEAR(bias_of(state), -0.2 * (0.1 - 1e-4) * 60, 200 * tolerance<real>);
  state = sphere_over_ground<real>(-0.1, -2, 0.5);
  EXPECT_NEAR(bias_of(state), 1, tolerance<real>);
}

// The friction impulse is a vector in the world: in a frame that has turned with the normal it is the same vector, put
// into the tangent plane.
TYPED_TEST(PrepareContacts, ImpulsesSurviveARotatedFrame) {
  using real = TypeParam;
  const double angle = 1e-3;
  InitialState<real> state = sphere_over_ground<real>(0, 0, 0);
  run_until_prepared(state);
  Buffers<real>& b = state.buffers;
  b.start_impulses[0] = {10, real(3), real(-2), 0};
  reference::run_stage(Stage::pack_points, b, state.params);
  reference::run_stage(Stage::prepare_contacts, b, state.params);
  const auto tangent_world = [&] {
    const ContactBlock<real>& c = b.contact_blocks[0];
    const double n[3] = {c.normal_x[0], c.normal_y[0], c.normal_z[0]}, k = -1 / (1 + n[2]);
    const double r1 = b.impulse_blocks[0].tangent_1[0], r2 = b.impulse_blocks[0].tangent_2[0];
    return Vector3{r1 * (1 + n[0] * n[0] * k) + r2 * n[0] * n[1] * k, r1 * n[0] * n[1] * k + r2 * (1 + n[1] * n[1] * k),
                   -r1 * n[0] - r2 * n[1]};
  };
  const Vector3 before = tangent_world();
  EXPECT_NEAR(before[0], 3, 10 * tolerance<real>);
  EXPECT_NEAR(before[1], -2, 10 * tolerance<real>);

  b.orientations[1] = {0, real(std::sin(angle / 2)), 0, real(std::cos(angle / 2))};  // the ground tilts
  state.params.substep = 1;
  reference::run_stage(Stage::prepare_contacts, b, state.params);
  const Vector3 after = tangent_world();
  EXPECT_EQ(double(b.impulse_blocks[0].normal[0]), 10);
  EXPECT_NEAR(after[0], 3, 1e-5);
  EXPECT_NEAR(after[1], -2, 1e-5);
  EXPECT_NEAR(after[2], -3 * angle, 1e-5);
}

TYPED_TEST(PrepareContacts, ImpulsesStartInsideTheCone) {
  using real = TypeParam;
  InitialState<real> state = sphere_over_ground<real>(0, 0, 0);
  run_until_prepared(state);
  Buffers<real>& b = state.buffers;
  b.start_impulses[0] = {2, real(3), real(4), 0};  // friction 0.5: at most 1
  reference::run_stage(Stage::pack_points, b, state.params);
  reference::run_stage(Stage::prepare_contacts, b, state.params);
  EXPECT_NEAR(std::hypot(double(b.impulse_blocks[0].tangent_1[0]), double(b.impulse_blocks[0].tangent_2[0])), 1,
              tolerance<real>);
  b.start_impulses[0] = {-1, 1, 0, 0};
  reference::run_stage(Stage::pack_points, b, state.params);
  reference::run_stage(Stage::prepare_contacts, b, state.params);
  EXPECT_EQ(double(b.impulse_blocks[0].normal[0]), 0);
  EXPECT_EQ(double(b.impulse_blocks[0].tangent_1[0]), 0);
  EXPECT_EQ(double(b.impulse_blocks[0].tangent_2[0]), 0);
}

TYPED_TEST(PrepareContacts, PaddingIsZero) {
  using real = TypeParam;
  InitialState<real> state = sphere_over_ground<real>(0, 0, 0);
  run_reference(state, {Stage::begin_step, Stage::update_bounds, Stage::sort_cells, Stage::find_pairs, Stage::collide,
                        Stage::match_contacts, Stage::color_contacts, Stage::pack_contacts, Stage::pack_points,
                        Stage::integrate_velocities});
  auto* words = reinterpret_cast<real*>(&state.buffers.contact_blocks[0]);
  const std::size_t rows = sizeof(ContactBlock<real>) / sizeof(real) / PACK;
  std::fill_n(words, rows * PACK, real(7));
  reference::run_stage(Stage::prepare_contacts, state.buffers, state.params);
  for (std::size_t row = 0; row < rows; ++row) {
    for (u32 lane = 1; lane < PACK; ++lane) EXPECT_EQ(words[row * PACK + lane], 0);
  }
}

// A step without room leaves everything as it is.
TYPED_TEST(PrepareContacts, AbortedStepsWriteNothing) {
  using real = TypeParam;
  InitialState<real> state = sphere_over_ground<real>(0, 0, 0);
  run_until_prepared(state);
  state.buffers.counters[COUNTER_STATUS] = STATUS_PAIRS_FULL;
  state.buffers.contact_blocks[0].bias[0] = 7;
  reference::run_stage(Stage::prepare_contacts, state.buffers, state.params);
  EXPECT_EQ(state.buffers.contact_blocks[0].bias[0], 7);
}

}  // namespace
}  // namespace lockstep::test::prepare_contacts_test
