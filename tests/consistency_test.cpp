// Scenes and states that were written with hashes that fit and indices that do not: each is refused by name before a
// kernel could follow an index.
#include "host/record/consistency.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "host/record/hdf5.hpp"
#include "host/scene/read.hpp"

namespace lockstep::consistency_test {
namespace {

using State = InitialState<float>;

State compiled(const char* name) { return compile<float>(read_scene(name)); }

// What is said of a state; "accepted" where nothing is.
std::string refusal_of(const State& state) {
  try {
    expect_consistent_constants(state);
    expect_consistent_lists(state);
  } catch (const h5::Failed& failed) {
    return failed.what();
  }
  return "accepted";
}

TEST(Consistency, EveryBuiltInSceneIsAccepted) {
  for (const SceneListing& scene : built_in_scenes())
    EXPECT_EQ(refusal_of(compiled(scene.name.c_str())), "accepted") << scene.name;
}

struct Damage {
  const char* scene;
  std::function<void(State&)> change;
  const char* refusal;
};

TEST(Consistency, IndicesThatPointNowhereAreRefused) {
  const Damage damages[] = {
      {"box_stack", [](State& s) { s.features = with(s.features, Feature::shear_springs); },
       "features: are those of no scene"},
      {"rover", [](State& s) { s.features = with(s.features, Feature::joints_ahead); },
       "features: are those of no scene"},
      {"terrain", [](State& s) { s.features &= ~static_cast<Features>(Feature::shape_trees); },
       "features: are those of no scene"},
      {"rover", [](State& s) { s.params.iterations = 0; }, "iterations: must be 1 .. 100000"},
      {"rover", [](State& s) { s.params.slop = -1; }, "slop: must be >= 0"},
      {"rover", [](State& s) { s.params.position_sweeps = 2; }, "features: are those of no scene"},
      {"rover", [](State& s) { s.params.theta = 0.5f; }, "features: are those of no scene"},
      {"free_flight", [](State& s) { s.features = with(s.features, Feature::jacobi); },
       "features: are those of no scene"},
      {"wrecking_ball", [](State& s) { s.features &= ~static_cast<Features>(Feature::jacobi); },
       "features: are those of no scene"},
      {"wrecking_ball", [](State& s) { s.features = with(s.features, Feature::angular_friction); },
       "features: are those of no scene"},
      {"rolling_resistance", [](State& s) { s.features = with(s.features, Feature::patches); },
       "features: are those of no scene"},
      {"box_stack", [](State& s) { s.features = with(with(s.features, Feature::dense), Feature::patches); },
       "features: are those of no scene"},
      {"cell_heap", [](State& s) { s.features = with(s.features, Feature::jacobi); },
       "features: are those of no scene"},
      {"cell_heap", [](State& s) { s.features = with(s.features, Feature::sleeping); },
       "features: are those of no scene"},
      {"cell_heap", [](State& s) { s.buffers.cell_sizes[0] = std::numeric_limits<float>::quiet_NaN(); },
       "cell_sizes[0]: is no length"},
      {"chain64", [](State& s) { s.features = with(s.features, Feature::soft_joints); },
       "features: are those of no scene"},
      {"chain64", [](State& s) { s.buffers.links[3].parent = 9; }, "links[3]: is no link of this scene"},
      {"chain64", [](State& s) { s.buffers.articulations[0].level_count = 99; },
       "articulations[0]: is no articulation of this scene"},
      {"chain64", [](State& s) { s.buffers.link_levels.back() = 7; }, "link_levels[64]: is no level of this scene"},
      {"chain64", [](State& s) { s.buffers.joint_infos[1].direct = 0; },
       "joint_infos[1]: is solved by nobody, or twice"},
      {"rope_bridge", [](State& s) { s.buffers.closures[0].link_a = NONE; },
       "closures[0]: closes no loop of this scene"},
      {"rope_bridge", [](State& s) { s.buffers.closure_sets[0].first_column = 9; },
       "closure_sets[0]: has other loops than this scene"},
      {"rope_bridge", [](State& s) { s.features = with(s.features, Feature::dense); },
       "features: are those of no scene"},
      {"rover", [](State& s) { s.buffers.joint_infos[1].direct = 1; }, "joint_infos[1]: is solved by nobody, or twice"},
      {"wrecking_ball", [](State& s) { s.buffers.gradient_laws[0].accelerated = 2; },
       "gradient_laws[0]: is of an unknown kind"},
      {"wrecking_ball", [](State& s) { s.buffers.joint_side_slots[0].slot_b[0] = 99; },
       "joint_side_slots[0]: is among the sides of other bodies"},
      {"wrecking_ball", [](State& s) { s.buffers.joint_side_starts.back() = 0; },
       "joint_side_starts[0]: counts other joints than there are"},
      {"box_stack", [](State& s) { s.buffers.world_ranges[0].body_count = 99; },
       "world_ranges[0]: reaches beyond what there is"},
      {"box_stack", [](State& s) { s.buffers.world_ranges[0].first_shape = 0xffffffffu; },
       "world_ranges[0]: reaches beyond what there is"},
      {"box_stack", [](State& s) { s.buffers.world_ranges[0].material_count = 0x10000; },
       "world_ranges[0]: reaches beyond what there is"},
      {"box_stack", [](State& s) { s.buffers.body_infos[3].world = 1; },
       "body_infos[3]: is of a world that there is not"},
      {"box_stack", [](State& s) { s.buffers.body_infos[3].kind = 3; }, "body_infos[3]: is of an unknown kind"},
      {"box_stack", [](State& s) { s.buffers.shape_infos[2].body = 11; },
       "shape_infos[2]: is of a body that there is not"},
      {"box_stack", [](State& s) { s.buffers.shape_infos[2].kind = SHAPE_KINDS; },
       "shape_infos[2]: is of an unknown kind"},
      {"box_stack", [](State& s) { s.buffers.shape_infos[2].material = 7; },
       "shape_infos[2]: is of a material that there is not"},
      {"box_stack", [](State& s) { s.buffers.shape_infos[2].kind = SHAPE_HULL; },
       "shape_infos[2]: is a hull that there is not"},
      {"box_stack", [](State& s) { s.buffers.planes[0] = 1; }, "planes[0]: is no plane"},
      {"box_stack", [](State& s) { s.buffers.planes[0] = 0xffffffffu; }, "planes[0]: is no plane"},
      {"hull_pile", [](State& s) { s.buffers.hulls[0].vertex_count = 0xffffu; },
       "hulls[0]: reaches beyond what there is"},
      {"hull_pile", [](State& s) { s.buffers.hull_faces[1].first_corner = 0xfffffff0u; },
       "hull_faces[1]: reaches beyond what there is"},
      {"hull_pile", [](State& s) { s.buffers.hull_corners[4] = 1000; }, "hull_corners[4]: is no vertex of its hull"},
      {"hull_pile", [](State& s) { s.buffers.hull_edges[2].face_left = 1000; },
       "hull_edges[2]: has no such vertices and faces"},
      {"air_table", [](State& s) { s.buffers.seams[0].kind = SHAPE_SPHERE; }, "seams[0]: is no box and no hull"},
      {"air_table", [](State& s) { s.buffers.seam_starts[1] = 9999; }, "seam_starts[1]: is out of order"},
      {"box_stack", [](State& s) { s.buffers.shape_infos[1].flags |= SHAPE_HAS_SEAMS; },
       "shape_infos[1]: has seams, of which the features say nothing"},
      {"terrain", [](State& s) { s.buffers.shape_infos[5].hull = HULL_IS_FACET | 9999u; },
       "shape_infos[5]: is a hull that there is not"},
      {"terrain", [](State& s) { s.buffers.facets[300].next[1] = 0xfffffff0u; },
       "facets[300]: has an edge that there is not"},
      {"terrain", [](State& s) { s.buffers.facets[300].flags |= 3u << FACET_EDGE_SHIFT(2); },
       "facets[300]: has an edge that there is not"},
      {"terrain", [](State& s) { s.buffers.facets[300].next[1] = s.buffers.facets[301].next[1]; },
       "facets[301]: is around no vertex"},
      {"terrain", [](State& s) { s.buffers.facet_edges[2].next = 3; }, "facet_edges[2]: is followed by no corner"},
      {"terrain", [](State& s) { s.buffers.shape_tree_items[7] = 0xffffffffu; },
       "shape_tree_items[7]: is of no tree of this scene"},
      {"terrain", [](State& s) { s.buffers.shape_trees[0].item_count += 1; },
       "shape_trees[0]: is of no tree of this scene"},
      {"terrain", [](State& s) { s.buffers.shape_tree_blocks[1].low_x[3] = 1e9f; },
       "shape_tree_blocks[1]: is of no tree of this scene"},
      {"terrain", [](State& s) { s.buffers.world_trees[0].tree_count = 9; },
       "world_trees[0]: is of no tree of this scene"},
      {"terrain", [](State& s) { s.buffers.top_level_shapes[0] = 1; },
       "top_level_shapes[0]: is of no tree of this scene"},
      {"terrain", [](State& s) { s.buffers.shape_infos[9].flags = 0; }, "shape_infos[9]: is of no tree of this scene"},
      {"rag_doll", [](State& s) { s.buffers.joint_infos[1].body_b = 1000; }, "joint_infos[1]: has no such bodies"},
      {"rag_doll", [](State& s) { s.buffers.joint_infos[1].kind = JOINT_KINDS; },
       "joint_infos[1]: is of an unknown kind"},
      {"rag_doll", [](State& s) { s.buffers.joint_lanes[0].body_a[15] = 1000; }, "joint_lanes[0]: has no such bodies"},
      {"rag_doll", [](State& s) { s.buffers.joint_lanes[0].joint[0] = 1000; }, "joint_lanes[0]: has no such joint"},
      {"rag_doll", [](State& s) { s.buffers.joint_phases.back() = 1000; }, nullptr},
      {"rag_doll", [](State& s) { s.buffers.joined_starts.back() = 1000; }, nullptr},
      {"rag_doll", [](State& s) { s.buffers.joined_bodies[0] = 1000; }, "joined_bodies[0]: is no body"},
      {"particles_rest", [](State& s) { s.buffers.world_ranges[0].plane_count = 2; },
       "world_ranges[0]: reaches beyond what there is"},
      {"particles_rest", [](State& s) { s.buffers.body_particles[2] = 0xffffffffu; }, nullptr},
      {"particles_rest", [](State& s) { --s.buffers.body_particles[5]; },
       "body_particles[5]: is not the number of particles"},
      {"particles_rest", [](State& s) { s.buffers.particle_bodies[7] = 4; },
       "particle_bodies[7]: is not the body that has the particle"},
      {"particles_rest", [](State& s) { s.buffers.plane_bodies[0] = 5; }, "plane_bodies[0]: is no body"},
  };
  for (const Damage& damage : damages) {
    State state = compiled(damage.scene);
    damage.change(state);
    const std::string refusal = refusal_of(state);
    if (damage.refusal)
      EXPECT_EQ(refusal, damage.refusal);
    else
      EXPECT_NE(refusal.find("]: is out of order"), std::string::npos) << refusal;
  }
}

TEST(Consistency, ListsThatPointNowhereOrAreOutOfOrderAreRefused) {
  const auto with_keys = [](std::vector<ContactKey> keys) {
    State state = compiled("box_stack");
    state.buffers.cached_count[0] = static_cast<u32>(keys.size());
    std::copy(keys.begin(), keys.end(), state.buffers.cached_keys.begin());
    return refusal_of(state);
  };
  EXPECT_EQ(with_keys({{1, 2, 0, 0}, {1, 2, 1, 0}, {2, 3, 0, 0}}), "accepted");
  EXPECT_EQ(with_keys({{1, 2, 0, 0}, {1, 99, 1, 0}}), "cached_keys[1]: has no such shapes");
  EXPECT_EQ(with_keys({{2, 3, 0, 0}, {1, 2, 1, 0}}), "cached_keys[1]: is out of order");

  const auto with_pairs = [](std::vector<Pair> pairs) {
    State state = compiled("sensor_gate");
    state.buffers.touching_count[0] = static_cast<u32>(pairs.size());
    std::copy(pairs.begin(), pairs.end(), state.buffers.touching.begin());
    return refusal_of(state);
  };
  EXPECT_EQ(with_pairs({{0, 1}, {0, 2}}), "accepted");
  EXPECT_EQ(with_pairs({{0, 1}, {0, 1}}), "touching[1]: is out of order");
  EXPECT_EQ(with_pairs({{0, 1}, {0xffffffffu, 1}}), "touching[1]: has no such shapes");

  const auto with_springs = [](std::vector<SpringKey> keys) {
    State state = compiled("particles_slope");
    state.buffers.spring_count[0] = static_cast<u32>(keys.size());
    std::copy(keys.begin(), keys.end(), state.buffers.spring_keys.begin());
    return refusal_of(state);
  };
  const u32 particles = compiled("particles_slope").sizes.particles;
  EXPECT_EQ(with_springs({{0, 1}, {0, particles}}), "accepted");
  EXPECT_EQ(with_springs({{0, 1}, {0, particles + 1}}), "spring_keys[1]: has no such particles");
  EXPECT_EQ(with_springs({{0, 1}, {particles, 1}}), "spring_keys[1]: has no such particles");
  EXPECT_EQ(with_springs({{1, 7}, {1, 6}}), "spring_keys[1]: is out of order");
}

}  // namespace
}  // namespace lockstep::consistency_test
