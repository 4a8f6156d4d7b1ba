// Every pair of kinds, hulls among them, in the kernel and the reference: poses at random, faces and sides that lie on
// each other, and poses full of ties (coincident centres, parallel edges, exact touch).
#include <gtest/gtest.h>

#include <map>

#include "tests/collision_states.hpp"
#include "tests/shapes/cases.hpp"

namespace lockstep::test::collide_pairs_test {
namespace {

template <class real>
BodyDescription body_at(u32 kind, const reference::WorldShape<real>& shape) {
  const auto &center = shape.center, &size = shape.size;
  const auto& rotation = shape.rotation;
  const Vector3 position = {center.x, center.y, center.z}, sizes = {size.x, size.y, size.z};
  const Quaternion orientation = {rotation.x, rotation.y, rotation.z, rotation.w};
  BodyDescription body = kind == SHAPE_PLANE    ? plane_body(position, orientation)
                         : kind == SHAPE_SPHERE ? sphere_body(position, sizes[0])
                         : kind == SHAPE_BOX || kind == SHAPE_HULL
                             ? box_body(position, sizes, orientation)
                             : round_body(ShapeKind(kind), position, sizes[0], sizes[1], orientation);
  body.orientation = orientation;
  body.shapes[0].kind = ShapeKind(kind);
  return body;
}

/// Each pair in a world of its own, with the tables of the hulls.
template <class real>
InitialState<real> state_of(const std::vector<Case<real>>& cases) {
  std::vector<std::vector<BodyDescription>> worlds;
  for (const Case<real>& c : cases) worlds.push_back({body_at(c.kinds.a, c.a), body_at(c.kinds.b, c.b)});
  InitialState<real> state = make_worlds<real>(worlds, 4 * u32(cases.size()));
  for (std::size_t i = 0; i < cases.size(); ++i) {
    state.buffers.shape_infos[2 * i].hull = cases[i].a.hull;
    state.buffers.shape_infos[2 * i + 1].hull = cases[i].b.hull;
  }
  Buffers<real>& to = state.buffers;
  const Buffers<real>& from = hulls<real>().buffers;
  to.hulls = from.hulls, to.hull_vertices = from.hull_vertices, to.hull_planes = from.hull_planes;
  to.hull_faces = from.hull_faces, to.hull_edges = from.hull_edges, to.hull_corners = from.hull_corners;
  state.sizes.hulls = u32(to.hulls.size()), state.sizes.hull_vertices = u32(to.hull_vertices.size());
  state.sizes.hull_faces = u32(to.hull_faces.size()), state.sizes.hull_edges = u32(to.hull_edges.size());
  state.sizes.hull_corners = u32(to.hull_corners.size());
  return state;
}

template <class real>
class CollidePairs : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CollidePairs, Precisions);

TYPED_TEST(CollidePairs, KernelMatchesReference) {
  using real = TypeParam;
  std::vector<Case<real>> cases;
  Random random(91);
  for (const PairOfKinds& kinds : all_pairs_of_kinds()) {
    for (u32 n = 0; n < 400; ++n) cases.push_back(meeting_anyhow<real>(kinds, random));
    for (u32 n = 0; n < 400; ++n) cases.push_back(lying<real>(kinds, random));
    for (u32 n = 0; n < lattice_cases; n += 31) cases.push_back(on_lattice<real>(kinds, n));
  }
  InitialState<real> state = state_of(cases);
  run_reference(state, {Stage::update_bounds, Stage::sort_cells, Stage::find_pairs});
  const Buffers<real> after = run_one_stage(Stage::collide, state.buffers, state.sizes, state.features, state.params,
                                            launches_of_a_step<real>());
  std::vector<bool> touched(cases.size());
  for (u32 i = 0; i < after.counters[COUNTER_CONTACTS]; ++i) touched[after.contacts[i].shape_a / 2] = true;
  std::map<PairOfKinds, u32> of_kinds;
  for (std::size_t i = 0; i < cases.size(); ++i) of_kinds[cases[i].kinds] += touched[i];
  for (const auto& [kinds, touching] : of_kinds)
    EXPECT_GT(touching, 200u) << kind_names[kinds.a] << " and " << kind_names[kinds.b];
}

}  // namespace
}  // namespace lockstep::test::collide_pairs_test
