#include "tests/bodies.hpp"
#include "tests/particle_scenes.hpp"

namespace lockstep {
namespace {

Vector3 vector_of(const Vec4<double>& a) { return {a.x, a.y, a.z}; }

/// Two balls that are one particle each, along x, the first at rest.
InitialState<double> two_balls(Vector3 velocity, Vector3 spin = {0, 0, 0}, double friction = 0.5) {
  BodyDescription a = solid_body(ball_shape(0.1), 1, {0, 0, 0}), b = solid_body(ball_shape(0.1), 3, {0.19, 0, 0});
  b.velocity = velocity;
  b.angular_velocity = spin;
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
TEST(PushParticles, WhatRollsDoesNotRub) {
  const Buffers<double> after =
      after_particle_stage(Stage::push_particles, two_balls({0, 0.095 * 20, 0}, {0, 0, 20}, 0.3));
  EXPECT_NEAR(after.particle_forces[0].y, 0, 1e-12);
}

// To the last bit, so that momentum is lost to rounding of sums alone.
template <class real>
void expect_action_is_reaction() {
  InitialState<real> state = lively_state<real>(0);
  ReferenceBackend<real> backend(state);
  for (const Stage stage : {Stage::begin_step, Stage::bound_particles, Stage::sort_particles, Stage::find_neighbours})
    backend.run(stage, state.params);
  Buffers<real> b = backend.buffers();
  u32 pairs = 0;
  for (u32 i = 0; i < state.sizes.particles; ++i) {
    for (u32 k = b.neighbour_starts[i]; k < b.neighbour_starts[i + 1]; ++k) {
      const u32 j = b.neighbours[k];
      if (b.body_infos[b.particle_bodies[j]].kind != BODY_DYNAMIC) continue;
      const auto alone = [&](u32 one, u32 two) {  // the list of particle `one` holds `two` alone
        InitialState<real> pair = state;
        pair.buffers = b;
        std::fill(pair.buffers.neighbour_starts.begin(), pair.buffers.neighbour_starts.end(), 0u);
        for (u32 n = one + 1; n < pair.buffers.neighbour_starts.size(); ++n) pair.buffers.neighbour_starts[n] = 1;
        pair.buffers.neighbours[0] = two;
        for (WorldRange& world : pair.buffers.world_ranges) world.plane_count = 0;
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
}

TEST(PushParticles, AVoidStepIsLeftAlone) {
  InitialState<float> state = lively_state<float>();
  state.buffers.counters[COUNTER_STATUS] = STATUS_PAIRS_FULL;
  ReferenceBackend<float> backend(state);
  backend.run(Stage::push_particles, state.params);
  EXPECT_EQ(backend.buffers().particle_forces[7].x, state.buffers.particle_forces[7].x);
}

}  // namespace
}  // namespace lockstep
