#include "tests/particle_scenes.hpp"

namespace lockstep::sort_particles_test {
namespace {

TEST(SortParticles, EachIsInItsBucketInOrder) {
  const InitialState<float> state = lively_state<float>();
  const Buffers<float> after = after_particle_stage(Stage::sort_particles, state);
  std::vector<u32> seen(state.sizes.particles, 0);
  for (u32 k = 0; k < state.params.buckets; ++k) {
    for (u32 slot = after.particle_starts[k]; slot < after.particle_starts[k + 1]; ++slot) {
      const u32 i = after.particle_items[slot];
      ++seen[i];
      EXPECT_EQ(after.particle_cells[i].bucket, k);
      if (slot > after.particle_starts[k]) {
        EXPECT_LT(after.particle_items[slot - 1], i);
      }
    }
  }
  for (const u32 times : seen) EXPECT_EQ(times, 1u);
}

// No limit of a cell: a thousand particles in one.
TEST(SortParticles, ACellTakesAll) {
  std::vector<BodyDescription> bodies(1000, solid_body(ball_shape(0.1), 1, {0.05, 0.05, 0.05}));
  const auto state = compile<float>(particle_scene(bodies, {.radius = 0.1, .stiffness = 100}, 1e-3));
  const Buffers<float> after = expect_particle_twins_agree(Stage::sort_particles, state);
  const u32 bucket = after.particle_cells[0].bucket;
  EXPECT_EQ(after.particle_starts[bucket + 1] - after.particle_starts[bucket], 1000u);
}

TEST(SortParticles, KernelMatchesReference) {
  for (const float far : {0.0f, 1e9f}) {  // beyond the grid too
    InitialState<float> state = lively_state<float>();
    state.buffers.positions[4].y += far;
    const Buffers<float> after = expect_particle_twins_agree(Stage::sort_particles, state);
    EXPECT_EQ((after.counters[COUNTER_STATUS] & STATUS_OUT_OF_GRID) != 0, far > 0);
  }
  expect_particle_twins_agree(Stage::sort_particles, lively_state<double>());
  const auto one = compile<float>(
      particle_scene({solid_body(ball_shape(0.1), 1, {0, 0, 1})}, {.radius = 0.1, .stiffness = 100}, 1e-3));
  expect_particle_twins_agree(Stage::sort_particles, one);
}

}  // namespace
}  // namespace lockstep::sort_particles_test
