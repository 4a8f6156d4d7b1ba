// The trees that bodies keep of their shapes: what they find is what a look at all shapes one by one finds.
#include <gtest/gtest.h>

#include <cstring>

#include "host/scene/read.hpp"
#include "tests/pair_lists.hpp"
#include "tests/surfaces.hpp"

namespace lockstep::test::shape_trees_test {
namespace {

template <class real>
class ShapeTrees : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ShapeTrees, Precisions);

TriangleMesh waves(u32 points) {
  return hills(points, 0.5, [](double x, double y) { return 0.2 * ((int(4 * x) * 7 + int(4 * y) * 3) % 5) / 5.0; });
}

/// A static body of boxes, spheres, capsules and cylinders in rows.
BodyDescription building(Random& random, const Vector3& position) {
  BodyDescription body;
  body.kind = BODY_STATIC;
  body.position = position;
  body.orientation = random.rotation();
  for (u32 n = 0; n < 60; ++n) {
    body.shapes.push_back(any_body(random, 0, 0.7).shapes[0]);
    body.shapes.back().offset = random.vector(2);
    body.shapes.back().rotation = random.rotation();
  }
  return body;
}

/// Grounds, one turned, one far out and on its way; a building; and dynamic bodies of all kinds about them.
Scene lively_scene(u32 seed, const Vector3& far = {0, 0, 0}) {
  Scene scene;
  scene.source = "lively";
  scene.settings.margin = 0.02;
  Random random(seed);
  const Vector3 east = exact::add(far, {8, 0, 0});
  scene.bodies = {surface_body(waves(9), far), sphere_body(far, 0.5), surface_body(waves(12), east),
                  building(random, exact::add(far, {0, 6, 0})), plane_body({0, 0, far[2] - 1})};
  scene.bodies[2].kind = BODY_KINEMATIC;
  scene.bodies[2].orientation = random.rotation();
  scene.bodies[2].velocity = random.vector(3);
  scene.bodies[2].angular_velocity = random.vector(2);
  for (u32 n = 0; n < 150; ++n) {
    BodyDescription body = any_body(random, 0, 0.8);
    const Vector3 spread = {random.between(-2, 9), random.between(-2, 7), random.between(-0.8, 1.2)};
    body.position = exact::add(far, spread);
    if (n % 5 == 0) body.shapes[0].mask = random.bits();
    scene.bodies.push_back(body);
  }
  return scene;
}

template <class real>
InitialState<real> compiled(const Scene& scene, Feature search) {
  const std::vector<Scene> worlds = {scene, lively_scene(91), scene};
  return with_search(search, compile<real>(std::span(worlds)));
}

/// The same state with all shapes at the top level.
template <class real>
InitialState<real> without_trees(InitialState<real> state) {
  Buffers<real>& b = state.buffers;
  state.features &= ~static_cast<Features>(Feature::shape_trees);
  state.sizes.tree_shapes = state.sizes.shape_trees = state.sizes.shape_tree_blocks = 0;
  state.params.tree_shapes = 0;
  for (ShapeInfo& shape : b.shape_infos) shape.flags &= ~u32{SHAPE_IS_IN_TREE};
  for (auto* list : {&b.top_level_shapes, &b.shape_tree_items}) list->clear();
  b.world_trees.clear();
  resize(b, state.sizes, state.features);
  return state;
}

template <class real>
PairList pairs_by(Feature search, InitialState<real> state) {
  if (search == Feature::bvh) find_by_tree(state);
  if (search == Feature::grid) run_reference(state, {Stage::update_bounds, Stage::sort_cells, Stage::find_pairs});
  if (search == Feature::all_pairs) run_reference(state, {Stage::update_bounds, Stage::compare_shapes});
  EXPECT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
  return pairs_of(state);
}

constexpr Feature searches[] = {Feature::grid, Feature::bvh, Feature::all_pairs};

template <class real>
u32 in_trees(const InitialState<real>& state, const PairList& pairs) {
  const auto is_in_tree = [&](u32 i) { return (state.buffers.shape_infos[i].flags & SHAPE_IS_IN_TREE) != 0; };
  return u32(std::ranges::count_if(pairs, [&](const auto& p) { return is_in_tree(p.first) || is_in_tree(p.second); }));
}

TYPED_TEST(ShapeTrees, FindWhatALookAtAllShapesFinds) {
  using real = TypeParam;
  for (const Vector3& far : {Vector3{0, 0, 0}, Vector3{3000, -4000, 500}}) {
    for (const Feature search : searches) {
      const InitialState<real> state = compiled<real>(lively_scene(5, far), search);
      ASSERT_TRUE(has(state.features, Feature::shape_trees));
      EXPECT_EQ(state.sizes.shape_trees, 9u);
      const PairList pairs = pairs_by(search, state), all = pairs_by(search, without_trees(state));
      EXPECT_EQ(pairs, all);
      EXPECT_GT(in_trees(state, pairs), 1000u);
      EXPECT_LT(in_trees(state, pairs), pairs.size());
    }
  }
}

TYPED_TEST(ShapeTrees, KernelsMatchTheReference) {
  using real = TypeParam;
  const InitialState<real> state = compiled<real>(lively_scene(6), Feature::bvh);
  const InitialState<real> grid = with_search(Feature::grid, [&] {
    InitialState<real> other = state;
    other.features &= ~static_cast<Features>(Feature::bvh);
    return other;
  }());
  expect_kernel_matches(Stage::update_bounds, state, {});
  expect_kernel_matches(Stage::sort_shapes, state, {Stage::update_bounds});
  expect_kernel_matches(Stage::build_tree, state, {Stage::update_bounds, Stage::sort_shapes});
  const Buffers<real> after =
      expect_kernel_matches(Stage::search_tree, state, {Stage::update_bounds, Stage::sort_shapes, Stage::build_tree});
  EXPECT_GT(after.counters[COUNTER_PAIRS], 1000u);
  expect_kernel_matches(Stage::sort_cells, grid, {Stage::update_bounds});
  expect_kernel_matches(Stage::find_pairs, grid, {Stage::update_bounds, Stage::sort_cells});
}

// On either side of a pair more partners than the first search keeps: a large ball over many triangles, many small ones
// on a large triangle, which comes before them or behind them in the scene.
TYPED_TEST(ShapeTrees, KernelsFindManyPartners) {
  using real = TypeParam;
  Scene scene;
  scene.source = "crowd";
  const BodyDescription ground = surface_body(hills(9, 20, [](double, double) { return 0.0; }));
  const BodyDescription fine = surface_body(waves(9), {100, 0, 0});
  for (u32 n = 0; n < 40; ++n) scene.bodies.push_back(sphere_body({5 + 0.2 * n, 3, 0.1}, 0.1));
  scene.bodies.push_back(ground);
  scene.bodies.push_back(fine);
  for (u32 n = 0; n < 40; ++n) scene.bodies.push_back(sphere_body({5 + 0.2 * n, 6, 0.1}, 0.1));
  scene.bodies.push_back(sphere_body({100, 0, 2}, 2.1));
  scene.bodies.insert(scene.bodies.begin(), sphere_body({100, 0, 2.2}, 2.1));
  for (const Feature search : searches) {
    InitialState<real> state = with_search(search, compile<real>(std::span<const Scene>(&scene, 1)));
    if (search != Feature::all_pairs) state.features &= ~static_cast<Features>(Feature::all_pairs);
    const PairList pairs = pairs_by(search, state);
    EXPECT_EQ(pairs, pairs_by(search, without_trees(state)));
    u32 most = 0;
    std::vector<u32> counts(state.sizes.shapes);
    for (const auto& [a, b] : pairs) most = std::max({most, ++counts[a], ++counts[b]});
    EXPECT_GT(most, 32u);
    const auto expect = [&](Stage stage, std::initializer_list<Stage> before) {
      EXPECT_EQ(expect_kernel_matches(stage, state, before).counters[COUNTER_PAIRS], pairs.size());
    };
    if (search == Feature::grid) expect(Stage::find_pairs, {Stage::update_bounds, Stage::sort_cells});
    if (search == Feature::all_pairs) expect(Stage::compare_shapes, {Stage::update_bounds});
    if (search == Feature::bvh)
      expect(Stage::search_tree, {Stage::update_bounds, Stage::sort_shapes, Stage::build_tree});
  }
}

/// The same with rays through all worlds: many down and along an axis, as users ask, and any.
template <class real>
InitialState<real> with_rays(InitialState<real> state, u32 count, const Vector3& far) {
  state.features = with(state.features, Feature::queries);
  state.sizes.rays = state.params.queries = count;
  resize(state.buffers, state.sizes, state.features);
  Random random(17);
  for (u32 n = 0; n < count; ++n) {
    Ray<real>& ray = state.buffers.rays[n];
    const Vector3 from = {random.between(-3, 10), random.between(-3, 8), random.between(-1, 4)};
    set(ray.origin, exact::add(far, from));
    set(ray.direction, n % 4 == 0 ? Vector3{0, 0, -1} : n % 4 == 1 ? Vector3{1, 0, 0} : exact::unit(random.vector(1)));
    ray.range = real(n % 5 == 0 ? 1 : 30);
    state.buffers.ray_filters[n] = {0, n % 3, n % 7 == 0 ? random.bits() : 0xffffffffu, 0};
  }
  return state;
}

// A ray meets the same shape at the same place, whether it looks into trees or at each shape.
TYPED_TEST(ShapeTrees, RaysMeetWhatALookAtAllShapesMeets) {
  using real = TypeParam;
  for (const Vector3& far : {Vector3{0, 0, 0}, Vector3{3000, -4000, 500}}) {
    const InitialState<real> state = with_rays(compiled<real>(lively_scene(5, far), Feature::bvh), 3000, far);
    InitialState<real> trees = state, none = without_trees(state);
    run_reference(trees, {Stage::cast_rays});
    run_reference(none, {Stage::cast_rays});
    u32 in_trees = 0;
    for (u32 n = 0; n < 3000; ++n) {
      const u32 met = trees.buffers.ray_shapes[n];
      EXPECT_EQ(met, none.buffers.ray_shapes[n]) << n;
      EXPECT_EQ(std::memcmp(&trees.buffers.ray_points[n], &none.buffers.ray_points[n], sizeof(RayPoint<real>)), 0) << n;
      in_trees += met != NONE && (state.buffers.shape_infos[met].flags & SHAPE_IS_IN_TREE) != 0 ? 1 : 0;
    }
    EXPECT_GT(in_trees, 120u);
    run_one_stage(Stage::cast_rays, state.buffers, state.sizes, state.features, state.params, launches());
  }
}

template <class real>
std::string state_after(const InitialState<real>& state, int steps) {
  ReferenceBackend<real> backend(state);
  for (int i = 0; i < steps; ++i) step(backend, state.params);
  EXPECT_EQ(backend.buffers().counters[COUNTER_STATUS], 0u);
  EXPECT_GT(backend.buffers().counters[COUNTER_CONTACTS], 0u);
  const auto& positions = backend.buffers().positions;
  return std::string(reinterpret_cast<const char*>(positions.data()), positions.size() * sizeof(positions[0]));
}

// Not a bit of a simulation depends on them.
TYPED_TEST(ShapeTrees, ChangeNoBit) {
  using real = TypeParam;
  const Scene lively = lively_scene(7);
  for (const bool sleeping : {false, true}) {
    Scene scene = lively;
    if (sleeping) scene.settings.sleeping = SleepSettings{};
    InitialState<real> state = compile<real>(std::span<const Scene>(&scene, 1));
    ASSERT_TRUE(has(state.features, Feature::shape_trees));
    EXPECT_EQ(state_after(state, 20), state_after(without_trees(state), 20));
  }
}

TEST(ShapeTreesTwins, AgreeWhereTheirBodiesMove) {
  Scene scene = lively_scene(8);
  scene.settings.sleeping = SleepSettings{};
  expect_twins_agree(compile<float>(std::span<const Scene>(&scene, 1)), 10, launches_of_a_step<float>());
}

TEST(ShapeTreesOf, BodiesThatNothingPushesAndThatHaveManyShapes) {
  Scene scene;
  scene.source = "few";
  Random random(3);
  scene.bodies = {surface_body(cube_mesh(1)), building(random, {4, 0, 0}), building(random, {8, 0, 0}),
                  building(random, {12, 0, 0}), sphere_body({0, 0, 4}, 1)};
  scene.bodies[2].shapes[5].trigger = true;
  scene.bodies[3].kind = BODY_DYNAMIC;
  scene.bodies[3].mass = 1;
  scene.bodies[3].inertia = {1, 1, 1};
  const InitialState<double> state = compile<double>(std::span<const Scene>(&scene, 1));
  ASSERT_EQ(state.sizes.shape_trees, 1u);
  EXPECT_EQ(state.buffers.shape_trees[0].body, 1u);
  EXPECT_EQ(state.sizes.tree_shapes, 60u);
  EXPECT_EQ(state.sizes.top_level(), 12u + 60 + 60 + 1);
  EXPECT_EQ(state.buffers.bounds.size(), state.sizes.top_level());

  scene.bodies.erase(scene.bodies.begin() + 1);
  const InitialState<double> none = compile<double>(std::span<const Scene>(&scene, 1));
  EXPECT_FALSE(has(none.features, Feature::shape_trees));
  EXPECT_TRUE(none.buffers.top_level_shapes.empty() && none.buffers.world_trees.empty());
}

}  // namespace
}  // namespace lockstep::test::shape_trees_test
