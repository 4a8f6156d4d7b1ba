#include "host/report/particle_overlap.hpp"

#include "tests/particle_scenes.hpp"

namespace lockstep::particle_overlap_test {
namespace {

// Two balls 5 mm deep in the floor and 20 mm in each other, and one that touches nothing.
TEST(ParticleOverlap, CountsEachPairOnceAndEachPlane) {
  std::vector<BodyDescription> bodies = {floor_body(), solid_body(ball_shape(0.1), 1, {0, 0, 0.095}),
                                         solid_body(ball_shape(0.1), 1, {0.18, 0, 0.095}),
                                         solid_body(ball_shape(0.1), 1, {5, 0, 3})};
  const auto state = compile<double>(particle_scene(bodies, {.radius = 0.1, .stiffness = 1000}, 1e-3));
  const Penetration found = particle_overlap(after_particle_stage(Stage::find_neighbours, state));
  EXPECT_EQ(found.touching, 3u);
  EXPECT_NEAR(found.max, 0.02, 1e-15);
  EXPECT_NEAR(found.mean, 0.03 / 3, 1e-15);
}

// Only one of two has a list where the other does not move.
TEST(ParticleOverlap, CountsWhatDoesNotMove) {
  std::vector<BodyDescription> bodies = {solid_body(ball_shape(0.1), 1, {0, 0, 0}),
                                         solid_body(ball_shape(0.1), 1, {0, 0.15, 0})};
  bodies[0].kind = BODY_STATIC;
  const auto state = compile<double>(particle_scene(bodies, {.radius = 0.1, .stiffness = 1000}, 1e-3));
  const Penetration found = particle_overlap(after_particle_stage(Stage::find_neighbours, state));
  EXPECT_EQ(found.touching, 1u);
  EXPECT_NEAR(found.max, 0.05, 1e-15);
}

}  // namespace
}  // namespace lockstep::particle_overlap_test
