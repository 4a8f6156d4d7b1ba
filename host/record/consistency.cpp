#include "host/record/consistency.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <tuple>

#include "host/record/hdf5.hpp"
#include "host/scene/body_joints.hpp"
#include "host/scene/compile_articulations.hpp"
#include "host/scene/compile_gradient.hpp"
#include "host/scene/compile_shape_trees.hpp"
#include "host/scene/joint_kinds.hpp"
#include "host/scene/setting_table.hpp"

namespace lockstep {

namespace {

[[noreturn]] void refuse(Buffer buffer, std::size_t record, const char* what) {
  throw h5::Failed(std::string(info(buffer).name) + "[" + std::to_string(record) + "]: " + what);
}

// Hard contacts and joints, each in a cone of its own and nobody asleep.
template <class real>
void expect_oracle(const InitialState<real>& state) {
  if (!state.oracle) return;
  const std::optional<Solver> solver = find_solver(state.oracle.name);
  if (!solver || !is_oracle(*solver)) throw h5::Failed("oracle: there is none of the name " + quote(state.oracle.name));
  bool fit = sizeof(real) == sizeof(double) && state.sizes.worlds == 1 && state.params.tolerance > 0 &&
             state.oracle.directions >= 3 && state.oracle.directions <= 256;
  for (const Feature feature :
       {Feature::soft_contacts, Feature::patches, Feature::jacobi, Feature::gradient, Feature::partitions,
        Feature::dense, Feature::articulations, Feature::sleeping, Feature::particles, Feature::angular_friction})
    fit = fit && !has(state.features, feature);
  if (!fit) throw h5::Failed("oracle: " + quote(state.oracle.name) + " steps no such scene");
}

// Settings that a step takes as they are; where joints are not closed by positions, it makes no sweeps over them.
template <class real>
void expect_step_settings(const StepParams<real>& params) {
  const auto expect = [](const char* name, auto value) {
    const Bounds& bounds = setting_info(name).bounds;
    if (!bounds.contains(value)) throw h5::Failed(std::string(name) + ": must be " + bounds.text());
  };
  StepParams<real> p = params;
  if (p.position_sweeps == 0) p.position_sweeps = 1;
  for (const real x : {p.slop, p.slop_share}) expect("slop", x);
  for (const real x : {p.margin, p.margin_share}) expect("margin", x);
  for (const real x : {p.correction_limit, p.correction_limit_share}) expect("correction_limit", x);
#define STEP_NUMBER(type, name, initial, bounds, unit, group, meaning) expect(#name, p.name);
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) expect(#name, p.name);
#include "kernels/step_settings.def"
}

template <class real>
void expect_features(const InitialState<real>& state) {
  const Features features = state.features;
  const bool ahead = has(features, Feature::joints) && state.params.theta != real(1);
  const bool moves = has(features, Feature::time_stepping) && !has(features, Feature::particles);
  bool fit = (moves || !has(features, Feature::sleeping)) && ahead == has(features, Feature::joints_ahead) &&
             has(features, Feature::separated_contacts) == (state.params.separation > 0) &&
             (has(features, Feature::closed_joints) || has(features, Feature::separated_contacts)) ==
                 (state.params.position_sweeps > 0);
  for (const auto& [feature, needed] : feature_needs) fit = fit && (!has(features, feature) || has(features, needed));
  const bool touching = has(features, Feature::contacts), jacobi = has(features, Feature::jacobi);
  const bool angular_friction = has(features, Feature::angular_friction), patches = has(features, Feature::patches);
  if (has(features, Feature::gradient))  // of contacts on copies of bodies, each in a cone, or of joints alone
    fit = fit && (touching || has(features, Feature::joints)) && jacobi == touching && !patches && !angular_friction;
  if (has(features, Feature::dense))  // of hard contacts on whole bodies, each in a cone
    fit = fit && !jacobi && !has(features, Feature::soft_contacts) && !patches && !angular_friction;
  if (has(features, Feature::articulations))  // of hard joints, in sweeps of Gauss-Seidel
    fit = fit && !jacobi && !has(features, Feature::soft_joints) && !has(features, Feature::gradient) &&
          !has(features, Feature::dense);
  if (has(features, Feature::separated_contacts))  // of hard contacts on whole bodies, in colours
    fit = fit && !jacobi && !has(features, Feature::soft_contacts) && !has(features, Feature::partitions) &&
          !has(features, Feature::pivots);
  fit = fit && has(features, Feature::shape_trees) == (state.sizes.tree_shapes > 0);
  fit = fit && !(patches && (angular_friction || has(features, Feature::static_friction)));
  if (has(features, Feature::partitions))
    fit = fit && !jacobi && !has(features, Feature::soft_contacts) && !has(features, Feature::sleeping) &&
          !has(features, Feature::dense);
  fit = fit && !(has(features, Feature::impact_laws) && has(features, Feature::elliptic_friction));
  if (!fit) throw h5::Failed("features: are those of no scene");
}

bool is_range(u32 first, u32 count, u32 size) { return first <= size && count <= size - first; }

// The shapes of a scene whose shapes cannot touch are counted, and not there.
bool has_its_shapes(const WorldRange& world, const Sizes& sizes) {
  return is_range(world.first_shape, world.shape_count, sizes.shapes) &&
         is_range(world.first_plane, world.plane_count, sizes.planes) && world.material_count <= 0xffffu &&
         is_range(world.first_material_pair, world.material_count * world.material_count, sizes.material_pairs);
}

template <class real>
void expect_bodies(const Buffers<real>& b, const Sizes& sizes, bool touching) {
  for (std::size_t w = 0; w < b.world_ranges.size(); ++w) {
    const WorldRange& world = b.world_ranges[w];
    if (!is_range(world.first_body, world.body_count, sizes.bodies) || (touching && !has_its_shapes(world, sizes)))
      refuse(Buffer::world_ranges, w, "reaches beyond what there is");
  }
  for (std::size_t i = 0; i < b.body_infos.size(); ++i) {
    if (b.body_infos[i].world >= sizes.worlds) refuse(Buffer::body_infos, i, "is of a world that there is not");
    if (b.body_infos[i].kind > BODY_DYNAMIC) refuse(Buffer::body_infos, i, "is of an unknown kind");
  }
}

template <class real>
void expect_impact_laws(const Buffers<real>& b) {
  for (std::size_t k = 0; k < b.impact_pairs.size(); ++k)
    if (b.impact_pairs[k].law >= IMPACT_LAWS) refuse(Buffer::impact_pairs, k, "is of an unknown law");
}

template <class real>
bool is_hull(u32 hull, const Buffers<real>& b) {
  return (hull & HULL_IS_FACET) != 0 ? (hull & ~HULL_IS_FACET) < b.facets.size() : hull < b.hulls.size();
}

template <class real>
void expect_shapes(const Buffers<real>& b, const Sizes& sizes) {
  for (std::size_t i = 0; i < b.shape_infos.size(); ++i) {
    const ShapeInfo& shape = b.shape_infos[i];
    if (shape.body >= sizes.bodies) refuse(Buffer::shape_infos, i, "is of a body that there is not");
    if (shape.kind >= SHAPE_KINDS) refuse(Buffer::shape_infos, i, "is of an unknown kind");
    if (shape.material >= b.world_ranges[b.body_infos[shape.body].world].material_count)
      refuse(Buffer::shape_infos, i, "is of a material that there is not");
    if (shape.kind == SHAPE_HULL && !is_hull(shape.hull, b))
      refuse(Buffer::shape_infos, i, "is a hull that there is not");
  }
  for (std::size_t k = 0; k < b.planes.size(); ++k) {
    if (b.planes[k] >= sizes.shapes || b.shape_infos[b.planes[k]].kind != SHAPE_PLANE)
      refuse(Buffer::planes, k, "is no plane");
  }
}

// Who follows the corners around a vertex comes back to where it began: of the corners that follow another one no two
// are followed by the same.
template <class real>
void expect_facets(const Buffers<real>& b) {
  const auto is_corner = [&](u32 corner) { return (corner >> 2) < b.facets.size() && (corner & 3) < 3; };
  for (std::size_t e = 0; e < b.facet_edges.size(); ++e)
    if (!is_corner(b.facet_edges[e].next)) refuse(Buffer::facet_edges, e, "is followed by no corner");
  std::vector<bool> follows(4 * b.facets.size()), is_seen(4 * b.facets.size());
  for (const bool first : {true, false}) {
    for (u32 f = 0; f < b.facets.size(); ++f) {
      for (u32 k = 0; k < 3; ++k) {
        const Facet<real>& facet = b.facets[f];
        const u32 kind = facet.flags >> FACET_EDGE_SHIFT(k) & 3;
        const bool stored = kind == FACET_EDGE_STORED;
        if (kind > FACET_EDGE_STORED || (stored ? facet.next[k] >= b.facet_edges.size() : !is_corner(facet.next[k])))
          refuse(Buffer::facets, f, "has an edge that there is not");
        const u32 next = stored ? b.facet_edges[facet.next[k]].next : facet.next[k];
        if (first) {
          follows[next] = true;
        } else if (follows[FACET_CORNER(f, k)]) {
          if (is_seen[next]) refuse(Buffer::facets, f, "is around no vertex");
          is_seen[next] = true;
        }
      }
    }
  }
}

template <class real>
void expect_hulls(const Buffers<real>& b, const Sizes& sizes) {
  for (std::size_t h = 0; h < b.hulls.size(); ++h) {
    const Hull& hull = b.hulls[h];
    if (!is_range(hull.first_vertex, hull.vertex_count, sizes.hull_vertices) ||
        !is_range(hull.first_face, hull.face_count, sizes.hull_faces) ||
        !is_range(hull.first_edge, hull.edge_count, sizes.hull_edges) || hull.vertex_count == 0)
      refuse(Buffer::hulls, h, "reaches beyond what there is");
    for (u32 f = hull.first_face; f < hull.first_face + hull.face_count; ++f) {
      const HullFace& face = b.hull_faces[f];
      if (!is_range(face.first_corner, face.corner_count, sizes.hull_corners) || face.corner_count < 3)
        refuse(Buffer::hull_faces, f, "reaches beyond what there is");
      for (u32 k = face.first_corner; k < face.first_corner + face.corner_count; ++k)
        if (b.hull_corners[k] >= hull.vertex_count) refuse(Buffer::hull_corners, k, "is no vertex of its hull");
    }
    for (u32 e = hull.first_edge; e < hull.first_edge + hull.edge_count; ++e) {
      const HullEdge& edge = b.hull_edges[e];
      if (std::max(edge.vertex_a, edge.vertex_b) >= hull.vertex_count ||
          std::max(edge.face_left, edge.face_right) >= hull.face_count)
        refuse(Buffer::hull_edges, e, "has no such vertices and faces");
    }
  }
}

// `rows` start where `starts` say: from 0 on, never backwards, up to their number.
void expect_starts(Buffer buffer, const std::vector<u32>& starts, std::size_t rows) {
  if (starts.empty()) return;
  if (starts[0] != 0) refuse(buffer, 0, "does not start at 0");
  for (std::size_t k = 1; k < starts.size(); ++k)
    if (starts[k] < starts[k - 1] || starts[k] > rows) refuse(buffer, k, "is out of order");
}

// Shapes that cover edges of others are boxes and hulls.
template <class real>
void expect_seams(const Buffers<real>& b, const Sizes& sizes) {
  expect_starts(Buffer::seam_starts, b.seam_starts, sizes.seams);
  for (std::size_t k = 0; k < b.seams.size(); ++k) {
    const Seam<real>& seam = b.seams[k];
    if (seam.kind != SHAPE_BOX && (seam.kind != SHAPE_HULL || !is_hull(seam.hull, b)))
      refuse(Buffer::seams, k, "is no box and no hull");
  }
  for (std::size_t k = 0; k < b.seam_sides.size(); ++k) {
    const auto [shape, neighbour] = b.seam_sides[k];
    if (shape >= b.shapes.size() || k < b.seam_starts[shape] || k >= b.seam_starts[shape + 1])
      refuse(Buffer::seam_sides, k, "is a seam of another shape");
    if (neighbour != NONE && neighbour >= b.shapes.size()) refuse(Buffer::seam_sides, k, "has no such neighbour");
  }
  for (std::size_t i = 0; i < b.shape_infos.size(); ++i)
    if ((b.shape_infos[i].flags & SHAPE_HAS_SEAMS) != 0 && b.seam_starts.empty())
      refuse(Buffer::shape_infos, i, "has seams, of which the features say nothing");
}

template <class real>
void expect_joints(const Buffers<real>& b, const Sizes& sizes) {
  for (std::size_t j = 0; j < b.joint_infos.size(); ++j) {
    const JointInfo& joint = b.joint_infos[j];
    if (std::max(joint.body_a, joint.body_b) > sizes.bodies) refuse(Buffer::joint_infos, j, "has no such bodies");
    if (joint.world >= sizes.worlds) refuse(Buffer::joint_infos, j, "is of a world that there is not");
    if (joint.kind >= JOINT_KINDS || joint.free > FREE_LENGTH || joint.locked >> JOINT_ROWS != 0)
      refuse(Buffer::joint_infos, j, "is of an unknown kind");
    const JointKind kind = static_cast<JointKind>(joint.kind);
    if ((is_non_holonomic(kind) || LOCKS_SKATE(joint.locked)) && b.rolling_radii.empty())
      refuse(Buffer::joint_infos, j, "locks velocities alone, of which the features say nothing");
  }
  for (std::size_t k = 0; k < b.joint_lanes.size(); ++k) {
    const JointLanes& lanes = b.joint_lanes[k];
    for (u32 lane = 0; lane < PACK; ++lane) {
      if (std::max(lanes.body_a[lane], lanes.body_b[lane]) > sizes.bodies)
        refuse(Buffer::joint_lanes, k, "has no such bodies");
      if (lanes.joint[lane] != NONE && lanes.joint[lane] >= sizes.joints)
        refuse(Buffer::joint_lanes, k, "has no such joint");
    }
  }
  expect_starts(Buffer::joint_phases, b.joint_phases, sizes.joint_blocks);
  expect_starts(Buffer::joined_starts, b.joined_starts, sizes.joined);
  for (std::size_t k = 0; k < b.joined_bodies.size(); ++k)
    if (b.joined_bodies[k] >= sizes.bodies) refuse(Buffer::joined_bodies, k, "is no body");
}

template <class real>
void expect_couplings(const Buffers<real>& b, const Sizes& sizes) {
  for (std::size_t k = 0; k < b.coupling_infos.size(); ++k) {
    if (!is_range(b.coupling_infos[k].first, b.coupling_infos[k].count, sizes.coupled_joints))
      refuse(Buffer::coupling_infos, k, "reaches beyond what there is");
    if (b.coupling_infos[k].world >= sizes.worlds) refuse(Buffer::coupling_infos, k, "is of a world that there is not");
  }
  for (std::size_t i = 0; i < b.coupled_joints.size(); ++i) {
    const CoupledJoint& coupled = b.coupled_joints[i];
    if (coupled.joint >= sizes.joints) refuse(Buffer::coupled_joints, i, "has no such joint");
    const JointInfo& info = b.joint_infos[coupled.joint];
    if (coupled.slot >= sizes.joint_blocks * PACK ||
        b.joint_lanes[coupled.slot / PACK].joint[coupled.slot % PACK] != coupled.joint ||
        coupled.body_a != info.body_a || coupled.body_b != info.body_b || coupled.free != info.free)
      refuse(Buffer::coupled_joints, i, "is another joint than it says");
  }
  if (!b.couplings.empty()) expect_starts(Buffer::coupling_phases, b.coupling_phases, sizes.couplings);
}

template <class Record>
void expect_same(Buffer buffer, const std::vector<Record>& found, const std::vector<Record>& right, const char* what) {
  if (found.size() != right.size()) refuse(buffer, found.size(), "is not the last of this scene");
  for (std::size_t i = 0; i < found.size(); ++i)
    if (std::memcmp(&found[i], &right[i], sizeof(Record)) != 0) refuse(buffer, i, what);
}

// They follow from bodies and joints.
template <class real>
void expect_articulations(const InitialState<real>& state) {
  const Buffers<real>& b = state.buffers;
  Buffers<real> right;
  right.body_infos = b.body_infos;
  right.joint_infos = b.joint_infos;
  right.joints = b.joints;
  right.joint_lanes = b.joint_lanes;
  right.masses = b.masses;
  if (has(state.features, Feature::articulations)) {
    find_articulations(Trees::all, right);
    if (right.links.size() != b.links.size()) find_articulations(Trees::that_carry, right);
    set_link_joints(right);
  }
  for (std::size_t j = 0; j < b.joint_infos.size(); ++j) {
    if (b.joint_infos[j].direct != (right.links.empty() ? 0 : right.joint_infos[j].direct))
      refuse(Buffer::joint_infos, j, "is solved by nobody, or twice");
  }
  expect_same(Buffer::articulations, b.articulations, right.articulations, "is no articulation of this scene");
  expect_same(Buffer::links, b.links, right.links, "is no link of this scene");
  expect_same(Buffer::link_levels, b.link_levels, right.link_levels, "is no level of this scene");
  expect_same(Buffer::closure_sets, b.closure_sets, right.closure_sets, "has other loops than this scene");
  expect_same(Buffer::closures, b.closures, right.closures, "closes no loop of this scene");
  const auto is_direct = [&](const JointLanes& lanes) {
    return lanes.joint[0] != NONE && b.joint_infos[lanes.joint[0]].direct != 0;
  };
  if (!std::ranges::is_partitioned(b.joint_lanes, std::not_fn(is_direct)))
    refuse(Buffer::joint_lanes, 0, "does not come before those that no sweep solves");
}

// The slots of the sides of joints follow from the joints.
template <class real>
void expect_gradient(const InitialState<real>& state) {
  const Buffers<real>& b = state.buffers;
  if (b.gradient_laws[0].accelerated > 1) refuse(Buffer::gradient_laws, 0, "is of an unknown kind");
  InitialState<real> wanted;
  wanted.buffers.body_infos = b.body_infos;
  wanted.buffers.joint_infos = b.joint_infos;
  wanted.buffers.joint_lanes = b.joint_lanes;
  compile_gradient(false, wanted);
  if (b.joint_side_starts != wanted.buffers.joint_side_starts)
    refuse(Buffer::joint_side_starts, 0, "counts other joints than there are");
  for (std::size_t k = 0; k < b.joint_side_slots.size(); ++k) {
    const JointSideSlots &found = b.joint_side_slots[k], &right = wanted.buffers.joint_side_slots[k];
    if (!std::ranges::equal(found.slot_a, right.slot_a) || !std::ranges::equal(found.slot_b, right.slot_b))
      refuse(Buffer::joint_side_slots, k, "is among the sides of other bodies");
  }
}

template <class real>
void expect_joint_lists(const InitialState<real>& state) {
  const Buffers<real>& b = state.buffers;
  Buffers<real> right;
  right.body_infos = b.body_infos;
  right.joint_infos = b.joint_infos;
  right.joints = b.joints;
  right.joint_lanes = b.joint_lanes;
  if (has(state.features, Feature::joints)) list_body_joints(right);
  if (!has(state.features, Feature::geometric_stiffness)) right.body_joints.clear();
  if (has(state.features, Feature::planar_joints)) list_planar_joints(right);
  expect_same(Buffer::body_joint_starts, b.body_joint_starts, right.body_joint_starts,
              "counts other joints than there are");
  expect_same(Buffer::body_joints, b.body_joints, right.body_joints, "is a joint of another body");
  expect_same(Buffer::planar_joints, b.planar_joints, right.planar_joints, "is no planar joint to what cannot move");
}

// They follow from bodies and shapes.
template <class real>
void expect_shape_trees(const InitialState<real>& state) {
  const Buffers<real>& b = state.buffers;
  InitialState<real> wanted;
  wanted.buffers.world_ranges = b.world_ranges;
  wanted.buffers.body_infos = b.body_infos;
  wanted.buffers.shape_infos = b.shape_infos;
  wanted.buffers.shapes = b.shapes;
  for (ShapeInfo& shape : wanted.buffers.shape_infos) shape.flags &= ~u32{SHAPE_IS_IN_TREE};
  compile_shape_trees(wanted);
  const Buffers<real>& right = wanted.buffers;
  const char* other = "is of no tree of this scene";
  expect_same(Buffer::shape_infos, b.shape_infos, right.shape_infos, other);
  expect_same(Buffer::top_level_shapes, b.top_level_shapes, right.top_level_shapes, other);
  expect_same(Buffer::world_trees, b.world_trees, right.world_trees, other);
  expect_same(Buffer::shape_trees, b.shape_trees, right.shape_trees, other);
  expect_same(Buffer::shape_tree_items, b.shape_tree_items, right.shape_tree_items, other);
  expect_same(Buffer::shape_tree_blocks, b.shape_tree_blocks, right.shape_tree_blocks, other);
}

template <class real>
void expect_cell_sizes(const Buffers<real>& b) {
  for (std::size_t w = 0; w < b.cell_sizes.size(); ++w)
    if (!(b.cell_sizes[w] > 0)) refuse(Buffer::cell_sizes, w, "is no length");
}

template <class real>
void expect_particles(const Buffers<real>& b, const Sizes& sizes) {
  for (std::size_t w = 0; w < b.world_ranges.size(); ++w) {
    if (!is_range(b.world_ranges[w].first_plane, b.world_ranges[w].plane_count, sizes.particle_planes))
      refuse(Buffer::world_ranges, w, "reaches beyond what there is");
  }
  expect_starts(Buffer::body_particles, b.body_particles, sizes.particles);
  if (b.body_particles.back() != sizes.particles)
    refuse(Buffer::body_particles, b.body_particles.size() - 1, "is not the number of particles");
  for (u32 body = 0; body < sizes.bodies; ++body) {
    for (u32 i = b.body_particles[body]; i < b.body_particles[body + 1]; ++i)
      if (b.particle_bodies[i] != body) refuse(Buffer::particle_bodies, i, "is not the body that has the particle");
  }
  for (std::size_t k = 0; k < b.plane_bodies.size(); ++k)
    if (b.plane_bodies[k] >= sizes.bodies) refuse(Buffer::plane_bodies, k, "is no body");
}

}  // namespace

template <class real>
void expect_consistent_constants(const InitialState<real>& state) {
  expect_step_settings(state.params);
  expect_features(state);
  expect_oracle(state);
  expect_bodies(state.buffers, state.sizes, has(state.features, Feature::contacts));
  expect_shapes(state.buffers, state.sizes);
  if (has(state.features, Feature::contacts)) expect_shape_trees(state);
  expect_impact_laws(state.buffers);
  expect_hulls(state.buffers, state.sizes);
  expect_facets(state.buffers);
  expect_seams(state.buffers, state.sizes);
  expect_joints(state.buffers, state.sizes);
  expect_couplings(state.buffers, state.sizes);
  expect_articulations(state);
  expect_cell_sizes(state.buffers);
  expect_joint_lists(state);
  if (has(state.features, Feature::gradient)) expect_gradient(state);
  if (has(state.features, Feature::particles)) expect_particles(state.buffers, state.sizes);
}

// An island is named by one of its bodies, which comes first.
template <class real>
void expect_sleepers(const Buffers<real>& b, u32 shapes) {
  for (std::size_t i = 0; i < b.sleepers.size(); ++i) {
    const u32 island = b.sleepers[i].island;
    if (island < ISLAND_WAKES && (island > i || b.sleepers[island].island != island))
      refuse(Buffer::sleepers, i, "sleeps in an island that there is not");
  }
  const u32 slept = b.slept_count.empty() ? 0 : b.slept_count[0];
  if (slept > b.slept_keys.size()) refuse(Buffer::slept_count, 0, "is more than there are");
  const auto as_tuple = [](const ContactKey& key) { return std::tuple(key.shape_a, key.shape_b, key.feature); };
  for (u32 k = 0; k < slept; ++k) {
    const ContactKey& key = b.slept_keys[k];
    if (std::max(key.shape_a, key.shape_b) >= shapes) refuse(Buffer::slept_keys, k, "has no such shapes");
    if (k > 0 && as_tuple(key) <= as_tuple(b.slept_keys[k - 1])) refuse(Buffer::slept_keys, k, "is out of order");
  }
}

template <class real>
void expect_consistent_lists(const InitialState<real>& state) {
  const Buffers<real>& b = state.buffers;
  const u32 shapes = state.sizes.shapes;
  const auto pair_of = [](const auto& record) { return std::pair(record.shape_a, record.shape_b); };
  const u32 keys = b.cached_count.empty() ? 0 : b.cached_count[0];
  if (keys > b.cached_keys.size()) refuse(Buffer::cached_count, 0, "is more than there are");
  for (u32 k = 0; k < keys; ++k) {
    const ContactKey& key = b.cached_keys[k];
    if (std::max(key.shape_a, key.shape_b) >= shapes) refuse(Buffer::cached_keys, k, "has no such shapes");
    if (k > 0 && pair_of(key) < pair_of(b.cached_keys[k - 1])) refuse(Buffer::cached_keys, k, "is out of order");
  }
  const u32 touching = b.touching_count.empty() ? 0 : b.touching_count[0];
  if (touching > b.touching.size()) refuse(Buffer::touching_count, 0, "is more than there are");
  for (u32 k = 0; k < touching; ++k) {
    const Pair& pair = b.touching[k];
    if (std::max(pair.shape_a, pair.shape_b) >= shapes) refuse(Buffer::touching, k, "has no such shapes");
    if (k > 0 && pair_of(pair) <= pair_of(b.touching[k - 1])) refuse(Buffer::touching, k, "is out of order");
  }
  expect_sleepers(b, shapes);
  const u32 particles = state.sizes.particles, planes = state.sizes.particle_planes;
  const u32 springs = b.spring_count.empty() ? 0 : b.spring_count[0];
  if (springs > b.spring_keys.size()) refuse(Buffer::spring_count, 0, "is more than there are");
  for (u32 k = 0; k < springs; ++k) {
    const SpringKey &key = b.spring_keys[k], &last = b.spring_keys[k > 0 ? k - 1 : 0];
    if (key.particle >= particles || key.partner >= particles + planes)
      refuse(Buffer::spring_keys, k, "has no such particles");
    if (k > 0 && std::pair(key.particle, key.partner) <= std::pair(last.particle, last.partner))
      refuse(Buffer::spring_keys, k, "is out of order");
  }
}

#define INSTANTIATE(real)                                                     \
  template void expect_consistent_constants<real>(const InitialState<real>&); \
  template void expect_consistent_lists<real>(const InitialState<real>&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
