#include "tests/bodies.hpp"
#include "tests/particle_scenes.hpp"

namespace lockstep::sum_particles_test {
namespace {

TEST(SumParticles, ForceAndTorqueAboutTheCentreOfMass) {
  const Buffers<double> b = after_particle_stage(Stage::sum_particles, lively_state<double>());
  const auto vector_of = [](const Vec4<double>& a) { return Vector3{a.x, a.y, a.z}; };
  u32 pushed = 0;
  for (u32 body = 0; body + 1 < b.body_particles.size(); ++body) {
    Vector3 force = {0, 0, 0}, torque = {0, 0, 0};
    for (u32 i = b.body_particles[body]; i < b.body_particles[body + 1]; ++i) {
      const Vector3 f = vector_of(b.particle_forces[i]);
      force = force + f;
      torque =
          torque + cross(vector_of(b.particle_positions[i]) - position(b, body), f) + vector_of(b.particle_moments[i]);
    }
    const Load<double>& load = b.particle_loads[body];
    EXPECT_NEAR(length(Vector3{load.force[0], load.force[1], load.force[2]} - force), 0, 1e-11);
    EXPECT_NEAR(length(Vector3{load.torque[0], load.torque[1], load.torque[2]} - torque), 0, 1e-11);
    if (b.body_infos[body].kind != BODY_DYNAMIC) {
      EXPECT_EQ(force, (Vector3{0, 0, 0}));
    }
    pushed += length(force) > 0.1;
  }
  EXPECT_GT(pushed, 10u);
}

TEST(SumParticles, KernelMatchesReference) {
  expect_particle_twins_agree(Stage::sum_particles, lively_state<float>());
  expect_particle_twins_agree(Stage::sum_particles, lively_state<double>());
}

}  // namespace
}  // namespace lockstep::sum_particles_test
