#include <gtest/gtest.h>

#include "tests/query_worlds.hpp"

namespace lockstep::test::find_overlaps_test {
namespace {

template <class real>
class FindOverlaps : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(FindOverlaps, Precisions);

// The kinds that the narrow phase has for sphere and box; cylinders follow with theirs.
BodyDescription solid_body(Random& random, u32 n) { return any_body(random, n % 3, 2); }

// A sphere overlaps what is closer to its centre than its radius.
TYPED_TEST(FindOverlaps, SpheresFeelWhatIsNear) {
  using real = TypeParam;
  Random random(100);
  std::vector<BodyDescription> bodies = {plane_body({0, 0, -1.5})};
  for (u32 n = 0; n < 120; ++n) bodies.push_back(solid_body(random, n));
  Simulation<real> simulation = simulate_in_reference(make_event_worlds<real>({bodies}, 10000));
  std::vector<VolumeQuery> volumes(100);
  for (VolumeQuery& volume : volumes) {
    volume.center = random.vector(2);
    volume.radius = random.between(0.1, 0.8);
  }
  const std::vector<Overlap> overlaps = simulation.find_overlaps(volumes);
  EXPECT_GT(overlaps.size(), 300u);
  u32 next = 0;
  for (u32 v = 0; v < volumes.size(); ++v) {
    for (u32 body = 0; body < bodies.size(); ++body) {
      const double gap = exact_distance(bodies[body], volumes[v].center) - volumes[v].radius;
      const bool told = next < overlaps.size() && overlaps[next].volume == v && overlaps[next].body == body;
      if (std::abs(gap) > 1e-5) {
        EXPECT_EQ(told, gap < 0) << v << " " << body << " " << gap;
      }
      next += told ? 1 : 0;
    }
  }
  EXPECT_EQ(next, overlaps.size());  // in order of the volumes and the shapes
}

// A box overlaps a sphere whose centre is closer to it than its radius; filters and triggers as for rays.
TYPED_TEST(FindOverlaps, BoxesFeelSpheres) {
  using real = TypeParam;
  Random random(101);
  std::vector<BodyDescription> bodies;
  for (u32 n = 0; n < 200; ++n) bodies.push_back(sphere_body(random.vector(2), random.between(0.05, 0.4)));
  bodies[3] = trigger_body(bodies[3]);
  for (u32 n = 0; n < 200; n += 2) bodies[n].shapes[0].category = 4;
  Simulation<real> simulation = simulate_in_reference(make_event_worlds<real>({bodies}, 20000));
  std::vector<VolumeQuery> volumes(50);
  for (u32 v = 0; v < volumes.size(); ++v) {
    volumes[v].kind = SHAPE_BOX;
    volumes[v].center = random.vector(2);
    volumes[v].rotation = random.rotation();
    volumes[v].half_extents = {random.between(0.1, 1), random.between(0.1, 1), random.between(0.1, 1)};
    if (v % 2) volumes[v].mask = 4;
  }
  const std::vector<Overlap> overlaps = simulation.find_overlaps(volumes);
  EXPECT_GT(overlaps.size(), 100u);
  u32 next = 0;
  for (u32 v = 0; v < volumes.size(); ++v) {
    BodyDescription box = box_body(volumes[v].center, volumes[v].half_extents, volumes[v].rotation);
    for (u32 body = 0; body < bodies.size(); ++body) {
      const double gap = exact_distance(box, bodies[body].position) - bodies[body].shapes[0].radius;
      const bool asked = body != 3 && (volumes[v].mask & bodies[body].shapes[0].category) != 0;
      const bool told = next < overlaps.size() && overlaps[next].volume == v && overlaps[next].body == body;
      if (std::abs(gap) > 1e-5) {
        EXPECT_EQ(told, asked && gap < 0) << v << " " << body << " " << gap;
      }
      next += told ? 1 : 0;
    }
  }
  EXPECT_EQ(next, overlaps.size());
}

// A list that is too short is made longer and the question asked again: 300 shapes in one place.
TYPED_TEST(FindOverlaps, ALongAnswerFindsRoom) {
  using real = TypeParam;
  const std::vector<BodyDescription> bodies(300, sphere_body({1, 1, 1}, 1));
  Simulation<real> simulation = simulate_in_reference(make_event_worlds<real>({bodies}, 64));
  VolumeQuery volume;
  volume.radius = 1;
  EXPECT_EQ(simulation.find_overlaps(std::span(&volume, 1)).size(), 300u);
  volume.radius = 0.5;
  EXPECT_EQ(simulation.find_overlaps(std::span(&volume, 1)).size(), 0u);
}

TYPED_TEST(FindOverlaps, KernelMatchesReference) {
  using real = TypeParam;
  std::vector<std::vector<BodyDescription>> worlds(3);
  Random random(102);
  for (u32 n = 0; n < 120; ++n) worlds[n % 2].push_back(solid_body(random, n));
  worlds[0].push_back(plane_body());
  InitialState<real> state = make_query_worlds<real>(worlds, 0, 100);
  for (u32 v = 0; v < 90; ++v) {
    Shape<real>& volume = state.buffers.volumes[v];
    const Quaternion rotation = random.rotation();
    set(volume.offset, random.vector(2));
    for (unsigned k = 0; k < 4; ++k) volume.rotation[k] = real(rotation[k]);
    for (unsigned k = 0; k < 3; ++k) volume.size[k] = real(random.between(0.1, 1));
    volume.bounding_radius = v % 2 ? volume.size[0] : real(1.8);
    state.buffers.volume_filters[v] = {u32(v % 2 ? SHAPE_SPHERE : SHAPE_BOX), v % 3, random.bits() | 1u, 0};
  }
  state.params.queries = 90;
  const Buffers<real> after =
      run_one_stage(Stage::find_overlaps, state.buffers, state.sizes, state.features, state.params, launches());
  EXPECT_GT(after.overlap_starts[100], 100u);
  state.params.overlap_capacity = state.sizes.overlaps = 20;
  const Buffers<real> full =
      run_one_stage(Stage::find_overlaps, state.buffers, state.sizes, state.features, state.params, launches());
  EXPECT_EQ(full.overlap_starts[100], after.overlap_starts[100]);
}

}  // namespace
}  // namespace lockstep::test::find_overlaps_test
