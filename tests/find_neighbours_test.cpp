#include "tests/bodies.hpp"
#include "tests/particle_scenes.hpp"

namespace lockstep::find_neighbours_test {
namespace {

using Lists = std::vector<std::vector<u32>>;

template <class real>
Lists lists_of(const Buffers<real>& b) {
  Lists lists;
  for (u32 i = 0; i + 1 < b.neighbour_starts.size(); ++i)
    lists.emplace_back(b.neighbours.begin() + b.neighbour_starts[i], b.neighbours.begin() + b.neighbour_starts[i + 1]);
  return lists;
}

// All pairs, and all planes, in double.
template <class real>
Lists all_pairs(const InitialState<real>& state, const Buffers<real>& b) {
  Lists lists(state.sizes.particles);
  const auto at = [](const Vec4<real>& a) { return Vector3{double(a.x), double(a.y), double(a.z)}; };
  for (u32 i = 0; i < state.sizes.particles; ++i) {
    const BodyInfo& mine = b.body_infos[b.particle_bodies[i]];
    if (mine.kind != BODY_DYNAMIC) continue;
    for (u32 j = 0; j < state.sizes.particles; ++j) {
      const BodyInfo& other = b.body_infos[b.particle_bodies[j]];
      if (b.particle_bodies[i] == b.particle_bodies[j] || mine.world != other.world) continue;
      const double gap = length(at(b.particle_positions[i]) - at(b.particle_positions[j])) - 2 * 0.04;
      const double speed = length(at(b.particle_velocities[i]) - at(b.particle_velocities[j]));
      if (gap <= double(state.params.margin) + double(state.params.dt) * state.params.substeps * speed)
        lists[i].push_back(j);
    }
    const WorldRange& world = b.world_ranges[mine.world];
    for (u32 k = world.first_plane; k < world.first_plane + world.plane_count; ++k) {  // at rest, not turned
      const ParticlePlane<real>& plane = b.particle_planes[k];
      const Vector3 from = at(b.particle_positions[i]) - at(b.positions[b.plane_bodies[k]]);
      double gap = -0.04;
      for (unsigned c = 0; c < 3; ++c) gap += double(plane.normal[c]) * (from[c] - double(plane.point[c]));
      const double speed = length(at(b.particle_velocities[i]));
      if (gap <= double(state.params.margin) + double(state.params.dt) * state.params.substeps * speed)
        lists[i].push_back(state.sizes.particles + k);
    }
  }
  return lists;
}

TEST(FindNeighbours, FindsWhatComparingAllFinds) {
  const InitialState<double> state = lively_state<double>();
  const Buffers<double> after = after_particle_stage(Stage::find_neighbours, state);
  EXPECT_EQ(lists_of(after), all_pairs(state, after));
  EXPECT_GT(after.counters[COUNTER_PAIRS], 1000u);
}

// Nor does a body that is joined to a plane's touch it.
TEST(FindNeighbours, JoinedBodiesHaveNone) {
  for (const u32 other : {3u, 0u}) {
    Scene scene = lively_particles();
    const auto count = [](const Scene& s) {
      const auto state = compile<double>(s);
      return after_particle_stage(Stage::find_neighbours, state).counters[COUNTER_PAIRS];
    };
    const u32 free = count(scene);
    scene.joints.push_back(
        {.name = "", .body_a = 2, .body_b = other, .anchor_a = {0.1, 0, 0.1}, .anchor_b = {0.1, 0, 0.1}});
    EXPECT_LT(count(scene), free) << other;
  }
}

TEST(FindNeighbours, KernelMatchesReference) {
  expect_particle_twins_agree(Stage::find_neighbours, lively_state<double>());
  InitialState<float> state = lively_state<float>();
  const Buffers<float> after = expect_particle_twins_agree(Stage::find_neighbours, state);
  state.params.pair_capacity = state.sizes.pairs = after.counters[COUNTER_PAIRS] - 1;
  state.buffers.neighbours.resize(state.sizes.pairs);
  const Buffers<float> full = expect_particle_twins_agree(Stage::find_neighbours, state);
  EXPECT_NE(full.counters[COUNTER_STATUS] & STATUS_PAIRS_FULL, 0u);
  EXPECT_EQ(full.counters[COUNTER_PAIRS_NEEDED], after.counters[COUNTER_PAIRS]);
}

}  // namespace
}  // namespace lockstep::find_neighbours_test
