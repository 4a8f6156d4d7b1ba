#include "tests/bodies.hpp"
#include "tests/particle_scenes.hpp"

namespace lockstep::bound_particles_test {
namespace {

TEST(BoundParticles, PositionsAreThoseOfARigidBody) {
  const InitialState<double> state = lively_state<double>();
  const Buffers<double> after = after_particle_stage(Stage::bound_particles, state);
  double largest = 0;
  for (u32 i = 0; i < state.sizes.particles; ++i) {
    const u32 body = after.particle_bodies[i];
    const Vec4<double>&a = after.particle_offsets[i], &x = after.particle_positions[i],
          &v = after.particle_velocities[i];
    const Vector3 arm = rotate(orientation(after, body), {a.x, a.y, a.z});
    EXPECT_NEAR(length(Vector3{x.x, x.y, x.z} - (position(after, body) + arm)), 0, 1e-14);
    const Vector3 speed = velocity(after, body) + cross(angular_velocity(after, body), arm);
    EXPECT_NEAR(length(Vector3{v.x, v.y, v.z} - speed), 0, 1e-13);
    largest = std::max(largest, 0.04 + state.params.dt * length(speed));
  }
  EXPECT_GE(std::bit_cast<float>(after.counters[COUNTER_MAX_EXTENT]), largest);
}

TEST(BoundParticles, ABodyWithoutAFinitePositionIsNamed) {
  InitialState<float> state = lively_state<float>();
  state.buffers.positions[5].x = std::numeric_limits<float>::quiet_NaN();
  const Buffers<float> after = expect_particle_twins_agree(Stage::bound_particles, state);
  EXPECT_NE(after.counters[COUNTER_STATUS] & STATUS_OUT_OF_GRID, 0u);
  EXPECT_EQ(NONE - after.counters[COUNTER_BAD_BODY], 5u);
}

TEST(BoundParticles, KernelMatchesReference) {
  expect_particle_twins_agree(Stage::bound_particles, lively_state<float>());
  expect_particle_twins_agree(Stage::bound_particles, lively_state<double>());
}

}  // namespace
}  // namespace lockstep::bound_particles_test
