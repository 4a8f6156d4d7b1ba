#include "tests/bodies.hpp"
#include "tests/particle_scenes.hpp"

namespace lockstep::update_particles_test {
namespace {

template <class real>
InitialState<real> with_substeps(u32 substeps, u32 substep) {
  InitialState<real> state = lively_state<real>();
  state.params.substeps = substeps;
  state.params.substep = substep;
  return state;
}

TEST(UpdateParticles, FollowTheirBodies) {
  InitialState<double> state = with_substeps<double>(2, 0);
  ReferenceBackend<double> backend(state);
  backend.run(Stage::integrate_positions, state.params);
  const Buffers<double> moved = backend.buffers();
  backend.run(Stage::update_particles, state.params);
  const Buffers<double>& b = backend.buffers();
  double farthest = 0;
  for (u32 i = 0; i < state.sizes.particles; ++i) {
    const u32 body = b.particle_bodies[i];
    const Vec4<double>&a = b.particle_offsets[i], &x = b.particle_positions[i];
    const Vector3 expected = position(b, body) + rotate(orientation(b, body), {a.x, a.y, a.z});
    EXPECT_NEAR(length(Vector3{x.x, x.y, x.z} - expected), 0, 1e-14);
    farthest = std::max(farthest, std::abs(x.x - moved.particle_positions[i].x));
  }
  EXPECT_GT(farthest, 1e-5);
}

TEST(UpdateParticles, AfterTheLastSubstepNobodyAsks) {
  InitialState<double> state = with_substeps<double>(2, 1);
  state.buffers.particle_positions[3].x = 77;
  ReferenceBackend<double> backend(state);
  backend.run(Stage::update_particles, state.params);
  EXPECT_EQ(backend.buffers().particle_positions[3].x, 77);
}

TEST(UpdateParticles, KernelMatchesReference) {
  expect_particle_twins_agree(Stage::update_particles, with_substeps<float>(3, 1));
  expect_particle_twins_agree(Stage::update_particles, with_substeps<double>(3, 1));
}

}  // namespace
}  // namespace lockstep::update_particles_test
