#include <gtest/gtest.h>

#include "tests/pair_lists.hpp"

namespace lockstep::test::sort_shapes_test {
namespace {

template <class real>
class SortShapes : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SortShapes, Precisions);

template <class real>
std::vector<u32> order_of(const std::vector<std::vector<BodyDescription>>& worlds) {
  InitialState<real> state = with_tree(make_worlds<real>(worlds, 16));
  run_reference(state, {Stage::update_bounds, Stage::sort_shapes});
  return state.buffers.tree_items;
}

// The eight corners of a cube: x is the lowest bit of Morton's code, then y, then z.
TYPED_TEST(SortShapes, FollowsMortonsCurve) {
  std::vector<BodyDescription> bodies;
  for (const u32 corner : {6u, 1u, 4u, 7u, 0u, 2u, 5u, 3u})
    bodies.push_back(sphere_body({double(corner & 1), double(corner >> 1 & 1), double(corner >> 2)}, 0.1));
  EXPECT_EQ(order_of<TypeParam>({bodies}), (std::vector<u32>{4, 1, 5, 7, 2, 6, 0, 3}));
}

TYPED_TEST(SortShapes, SmallBeforeLargeAndPlanesLast) {
  const std::vector<BodyDescription> bodies = {plane_body(), sphere_body({0, 0, 0}, 5), sphere_body({9, 9, 9}, 0.01),
                                               box_body({5, 5, 5}, {5, 0.1, 0.1}), sphere_body({1, 1, 1}, 0.01)};
  EXPECT_EQ(order_of<TypeParam>({bodies}), (std::vector<u32>{4, 2, 1, 3, 0}));
}

TYPED_TEST(SortShapes, ShapesAtOnePositionStayInOrder) {
  const std::vector<BodyDescription> bodies(3000, sphere_body({3, 3, 3}, 0.5));
  const std::vector<u32> order = order_of<TypeParam>({bodies});
  for (u32 i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i);
}

// Worlds follow each other, each in the order that it has alone.
TYPED_TEST(SortShapes, AWorldOfABatchHasItsLoneOrder) {
  std::vector<std::vector<BodyDescription>> worlds;
  std::vector<u32> lone;
  for (u32 w = 0; w < 40; ++w) {
    Random random(w);
    worlds.push_back({sphere_body({0, 0, 0}, 1)});
    for (u32 n = 0; n < 30 + w; ++n) worlds.back().push_back(sphere_body(random.vector(5 + w), 0.3));
    const u32 first = u32(lone.size());
    for (const u32 i : order_of<TypeParam>({worlds.back()})) lone.push_back(first + i);
  }
  EXPECT_EQ(order_of<TypeParam>(worlds), lone);
}

// One that has left for good leaves the others apart.
TYPED_TEST(SortShapes, AnEscapedBodyDoesNotMixTheOthers) {
  Random random(12);
  std::vector<BodyDescription> bodies;
  for (u32 n = 0; n < 1000; ++n) bodies.push_back(sphere_body(random.vector(50), 0.5));
  bodies.push_back(sphere_body({0, 0, -100000}, 0.5));
  const std::vector<u32> order = order_of<TypeParam>({bodies});
  double path_length = 0;
  for (u32 k = 0; k + 1 < order.size(); ++k) {
    if (order[k] == 1000 || order[k + 1] == 1000) continue;
    const Vector3 &a = bodies[order[k]].position, &b = bodies[order[k + 1]].position;
    path_length += exact::length(exact::subtract(a, b));
  }
  EXPECT_LT(path_length / 999, 20);  // two of any order are 66 m apart on the average
}

TYPED_TEST(SortShapes, KernelMatchesReference) {
  using real = TypeParam;
  for (const auto& worlds : {lively_worlds(), worlds_of_all_kinds()}) {
    InitialState<real> state = with_tree(make_worlds<real>(worlds, 1000));
    expect_kernel_matches(Stage::sort_shapes, state, {Stage::update_bounds});
    state.buffers.positions[100].x = real(1e20);
    state.buffers.positions[50].y = std::numeric_limits<real>::quiet_NaN();
    expect_kernel_matches(Stage::sort_shapes, state, {Stage::update_bounds});
  }
  for (const u32 worlds : {1u, 2u, 1000u}) {
    const std::vector<std::vector<BodyDescription>> batch(worlds, {sphere_body({1, 2, 3}, 0.5)});
    expect_kernel_matches(Stage::sort_shapes, with_tree(make_worlds<real>(batch, 16)), {Stage::update_bounds});
  }
}

}  // namespace
}  // namespace lockstep::test::sort_shapes_test
