#include "tests/bodies.hpp"
#include "tests/particle_scenes.hpp"

namespace lockstep::push_particles_test {
namespace {

Vector3 vector_of(const Vec4<double>& a) { return {a.x, a.y, a.z}; }

/// Two balls that are one particle each, along x, the first at rest.
InitialState<double> two_balls(Vector3 velocity, Vector3 angular_velocity = {0, 0, 0}, double friction = 0.5) {
  BodyDescription a = solid_body(ball_shape(0.1), 1, {0, 0, 0}), b = solid_body(ball_shape(0.1), 3, {0.19, 0, 0});
  b.velocity = velocity;
  b.angular_velocity = angular_velocity;
  return compile<double>(
      particle_scene({a, b}, {.radius = 0.1, .stiffness = 1000, .restitution = 0.5, .friction = friction}, 1e-3));
}

TEST(PushParticles, OverlapAtRestIsASpring) {
  const Buffers<double> after = after_particle_stage(Stage::push_particles, two_balls({0, 0, 0}));
  EXPECT_NEAR(length(vector_of(after.particle_forces[0]) - Vector3{-10, 0, 0}), 0, 1e-12);
  EXPECT_EQ(vector_of(after.particle_moments[0]), (Vector3{0, 0, 0}));
}

TEST(PushParticles, ApproachAddsTheDamperAndNothingPulls) {
  const InitialState<double> state = two_balls({-0.5, 0, 0});
  const double damping = double(state.buffers.particle_laws[0].damping) * std::sqrt(1 / (1 + 1.0 / 3));
  const Buffers<double> after = after_particle_stage(Stage::push_particles, state);
  EXPECT_NEAR(after.particle_forces[0].x, -10 - 0.5 * damping, 1e-12);
  const Buffers<double> parting = after_particle_stage(Stage::push_particles, two_balls({50, 0, 0}));
  EXPECT_EQ(parting.particle_forces[0].x, 0);
}

TEST(PushParticles, FrictionIsAlongTheSlipAndBoundedByCoulomb) {
  const Buffers<double> after = after_particle_stage(Stage::push_particles, two_balls({0, 100, 0}, {0, 0, 0}, 0.3));
  EXPECT_NEAR(after.particle_forces[0].y, 0.3 * 10, 1e-12);
  EXPECT_NEAR(after.particle_moments[0].z, 0.095 * 3, 1e-12) << "at the middle of the overlap";
  const InitialState<double> slow = two_balls({0, 1e-3, 0}, {0, 0, 0}, 0.3);
  const double shear = double(slow.buffers.particle_laws[0].shear_damping) * std::sqrt(1 / (1 + 1.0 / 3));
  EXPECT_NEAR(after_particle_stage(Stage::push_particles, slow).particle_forces[0].y, 1e-3 * shear, 1e-15);
}

// v = w x r at the contact: a ball that rolls on another does not slip.
TEST(PushParticles, RollingFeelsNoSlidingFriction) {
  const Buffers<double> after =
      after_particle_stage(Stage::push_particles, two_balls({0, 0.095 * 20, 0}, {0, 0, 20}, 0.3));
  EXPECT_NEAR(after.particle_forces[0].y, 0, 1e-12);
}

/// What one sub-step makes of a stretch, where the second ball passes at this speed along y.
struct Sheared {
  double force, stretch;
  Vector3 along;
};
Sheared shear(double speed, Vector3 stretch) {
  InitialState<double> state = two_balls({0, speed, 0}, {0, 0, 0}, 0.3);
  state.features = with(state.features, Feature::shear_springs);
  state.buffers.particle_laws[0].shear_stiffness = 500;
  resize(state.buffers, state.sizes, state.features);
  state.buffers = after_particle_stage(Stage::match_springs, state);
  state.buffers.stretches[0] = {stretch[0], stretch[1], stretch[2], 0};
  ReferenceBackend<double> backend(state);
  backend.run(Stage::push_particles, state.params);
  const Buffers<double>& after = backend.buffers();
  return {after.particle_forces[0].y, after.stretches[0].y, vector_of(after.stretches[0])};
}

TEST(PushParticles, ASpringAlongTheSurfaceRemembersTheSlip) {
  const InitialState<double> state = two_balls({0, 1e-3, 0}, {0, 0, 0}, 0.3);
  const double damper = 1e-3 * state.buffers.particle_laws[0].shear_damping * std::sqrt(1 / (1 + 1.0 / 3));
  const Sheared first = shear(1e-3, {0, 0, 0});
  EXPECT_NEAR(first.stretch, 1e-3 * 1e-3, 1e-18) << "dt times the slip";
  EXPECT_NEAR(first.force, 500 * 1e-6 + damper, 1e-12);
  const Sheared later = shear(1e-3, {0, 2e-3, 0});
  EXPECT_NEAR(later.stretch, 2e-3 + 1e-6, 1e-16);
  EXPECT_NEAR(later.force, 500 * (2e-3 + 1e-6) + damper, 1e-12);
  EXPECT_NEAR(shear(0, {0, 2e-3, 0}).force, 500 * 2e-3, 1e-12) << "also at rest";
}

TEST(PushParticles, AStretchedSpringIsProjectedOntoThePlaneOfTheContact) {
  EXPECT_NEAR(length(shear(0, {7e-3, 1e-3, 2e-3}).along - Vector3{0, 1e-3, 2e-3}), 0, 1e-17);
}

TEST(PushParticles, WhereSurfacesSlideTheSpringGivesCoulombsForceAndNoMore) {
  const Sheared still = shear(0, {0, 1, 0});
  EXPECT_NEAR(still.force, 0.3 * 10, 1e-12);
  EXPECT_NEAR(still.stretch, 0.3 * 10 / 500, 1e-15);
  const double damper =
      2 * double(two_balls({0, 0, 0}).buffers.particle_laws[0].shear_damping) * std::sqrt(1 / (1 + 1.0 / 3));
  const Sheared moving = shear(2, {0, 1, 0});
  EXPECT_NEAR(moving.force, 0.3 * 10, 1e-12);
  EXPECT_NEAR(moving.stretch, (0.3 * 10 - damper) / 500, 1e-15) << "with the damper";
}

TEST(PushParticles, WhatSeparatesForgets) {
  InitialState<double> state = two_balls({0, 0, 0});
  state.features = with(state.features, Feature::shear_springs);
  state.buffers.particle_laws[0].shear_stiffness = 500;
  resize(state.buffers, state.sizes, state.features);
  state.buffers.positions[1].x = 0.201;
  state.buffers = after_particle_stage(Stage::match_springs, state);
  ASSERT_EQ(state.buffers.counters[COUNTER_PAIRS], 2u) << "near, and apart";
  state.buffers.stretches[0].y = 1;
  ReferenceBackend<double> backend(state);
  backend.run(Stage::push_particles, state.params);
  EXPECT_EQ(backend.buffers().stretches[0].y, 0);
}

// To the last bit, so that momentum is lost to rounding of sums alone.
template <class real>
void expect_action_is_reaction() {
  InitialState<real> state = lively_state<real>(2, sprung);
  const Buffers<real> b = after_particle_stage(Stage::match_springs, state);
  const auto stretch_of = [&](u32 one, u32 two) {
    const auto first = b.neighbours.begin() + b.neighbour_starts[one];
    return b
        .stretches[std::find(first, b.neighbours.begin() + b.neighbour_starts[one + 1], two) - b.neighbours.begin()];
  };
  u32 pairs = 0;
  for (u32 i = 0; i < state.sizes.particles; ++i) {
    for (u32 k = b.neighbour_starts[i]; k < b.neighbour_starts[i + 1]; ++k) {
      const u32 j = b.neighbours[k];
      if (j >= state.sizes.particles || b.body_infos[b.particle_bodies[j]].kind != BODY_DYNAMIC) continue;
      const auto alone = [&](u32 one, u32 two) {  // the list of particle `one` holds `two` alone
        InitialState<real> pair = state;
        pair.buffers = b;
        std::fill(pair.buffers.neighbour_starts.begin(), pair.buffers.neighbour_starts.end(), 0u);
        for (u32 n = one + 1; n < pair.buffers.neighbour_starts.size(); ++n) pair.buffers.neighbour_starts[n] = 1;
        pair.buffers.neighbours[0] = two;
        pair.buffers.stretches[0] = stretch_of(one, two);
        ReferenceBackend<real> one_pair(pair);
        one_pair.run(Stage::push_particles, pair.params);
        return one_pair.buffers().particle_forces[one];
      };
      const Vec4<real> f = alone(i, j), g = alone(j, i);
      ASSERT_EQ(f.x, -g.x);
      ASSERT_EQ(f.y, -g.y);
      ASSERT_EQ(f.z, -g.z);
      pairs += f.x != 0;
      if (pairs == 40) return;
    }
  }
  FAIL() << pairs << " pairs touched";
}
TEST(PushParticles, ActionIsReactionToTheBit) {
  expect_action_is_reaction<float>();
  expect_action_is_reaction<double>();
}

TEST(PushParticles, KernelMatchesReference) {
  const Buffers<float> after = expect_particle_twins_agree(Stage::push_particles, lively_state<float>());
  u32 pushed = 0;
  for (const Vec4<float>& force : after.particle_forces) pushed += force.x != 0;
  EXPECT_GT(pushed, 100u);
  expect_particle_twins_agree(Stage::push_particles, lively_state<double>());
  expect_particle_twins_agree(Stage::push_particles, lively_state<float>(3, sprung));
  expect_particle_twins_agree(Stage::push_particles, lively_state<double>(3, sprung));
}

TEST(PushParticles, AnAbortedStepIsLeftAlone) {
  InitialState<float> state = lively_state<float>();
  state.buffers.counters[COUNTER_STATUS] = STATUS_PAIRS_FULL;
  ReferenceBackend<float> backend(state);
  backend.run(Stage::push_particles, state.params);
  EXPECT_EQ(backend.buffers().particle_forces[7].x, state.buffers.particle_forces[7].x);
}

}  // namespace
}  // namespace lockstep::push_particles_test
