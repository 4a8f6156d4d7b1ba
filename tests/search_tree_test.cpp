// The tests of the grid (find_pairs_test.cpp) hold the tree to the same pairs; here are what only the tree is asked,
// the kernels, and an oracle that knows nothing of bounds.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/closest_points.hpp"
#include "tests/pair_lists.hpp"

namespace lockstep::test::search_tree_test {
namespace {

template <class real>
class SearchTree : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SearchTree, Precisions);

const auto before = {Stage::update_bounds, Stage::sort_shapes, Stage::build_tree};

template <class real>
PairList found_by_tree(InitialState<real>& state) {
  find_by_tree(state);
  EXPECT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
  return pairs_of(state);
}

std::vector<BodyDescription> mixed_bodies(u32 seed, u32 count, double space, double size) {
  Random random(seed);
  std::vector<BodyDescription> bodies;
  for (u32 n = 0; n < count; ++n) bodies.push_back(any_body(random, space, n % 50 == 0 ? 10 * size : size));
  return bodies;
}

// Whatever comes within the margin at some time of the step is a pair. The bodies are few and slow enough for an
// iteration that finds the closest points of two convex shapes from their supports, in double; that of the least
// distance is a witness, so that nothing here depends on how well it converges.
TYPED_TEST(SearchTree, HasEveryPairThatComesCloseWithinTheStep) {
  using real = TypeParam;
  u32 close = 0;
  for (const u32 seed : {1u, 2u, 3u}) {
    const std::vector<BodyDescription> bodies = mixed_bodies(seed, 200, 1.5, 0.8);
    InitialState<real> grid = make_worlds<real>({bodies}, 100000);
    const PairList pairs = found(grid);  // by both searches
    EXPECT_EQ(pairs, brute_force(grid));
    const double h = double(grid.params.dt) * grid.params.substeps;
    for (u32 i = 0; i < bodies.size(); ++i) {
      for (u32 j = i + 1; j < bodies.size(); ++j) {
        double distance = 1e9;
        for (const double t : {0.0, 0.5 * h, h})
          distance = std::min(distance, distance_between(moved(bodies[i], t), moved(bodies[j], t)));
        if (distance > double(grid.params.margin)) continue;
        ++close;
        EXPECT_TRUE(std::ranges::binary_search(pairs, std::pair(i, j))) << i << " " << j << " at " << distance;
      }
    }
    EXPECT_LT(pairs.size(), bodies.size() * bodies.size() / 4);
  }
  EXPECT_GT(close, 500u);
}

// Far out shapes have no cell, and still a box.
TYPED_TEST(SearchTree, FindsWhatHasNoCell) {
  using real = TypeParam;
  InitialState<real> state = with_tree(
      make_worlds<real>({{sphere_body({1e12, 0, 0}, 0.5), sphere_body({0, 0, 0}, 0.5), sphere_body({1e12, 0, 0}, 0.5),
                          sphere_body({0.9, 0, 0}, 0.5), plane_body({0, 0, -0.4})}},
                        100));
  EXPECT_EQ(found_by_tree(state), (PairList{{0, 2}, {0, 4}, {1, 3}, {1, 4}, {2, 4}, {3, 4}}));
}

TYPED_TEST(SearchTree, HugeAmongTiny) {
  using real = TypeParam;
  Random random(13);
  std::vector<BodyDescription> bodies = {box_body({0, 0, -1}, {100, 100, 1}), sphere_body({0, 0, 200}, 150)};
  for (u32 n = 0; n < 3000; ++n)
    bodies.push_back(sphere_body({random.between(-90, 90), random.between(-90, 90), random.between(0, 60)},
                                 random.between(0.01, 0.5), random.vector(1)));
  InitialState<real> state = with_tree(make_worlds<real>({bodies}, 100000));
  const PairList pairs = found_by_tree(state);
  EXPECT_EQ(pairs, brute_force(state));
  EXPECT_GT(pairs.size(), 50u);
}

TYPED_TEST(SearchTree, KernelMatchesReference) {
  using real = TypeParam;
  for (const auto& worlds : {lively_worlds(), worlds_of_all_kinds()}) {
    InitialState<real> state = with_tree(make_worlds<real>(worlds, 100000));
    state.buffers.positions[50].y = std::numeric_limits<real>::quiet_NaN();
    const Buffers<real> after = expect_kernel_matches(Stage::search_tree, state, before);
    EXPECT_GT(after.counters[COUNTER_PAIRS], 1000u);
    state.params.pair_capacity = state.sizes.pairs = after.counters[COUNTER_PAIRS] - 1;
    const Buffers<real> full = expect_kernel_matches(Stage::search_tree, state, before);
    EXPECT_NE(full.counters[COUNTER_STATUS] & STATUS_PAIRS_FULL, 0u);
  }
}

// Three levels, and runs that are not full.
TYPED_TEST(SearchTree, KernelMatchesReferenceOfLargeTrees) {
  using real = TypeParam;
  for (const u32 count : {1u, 17u, 257u, 6000u}) {
    InitialState<real> state = with_tree(make_worlds<real>({mixed_bodies(count, count, 12, 0.3)}, 200000));
    expect_kernel_matches(Stage::search_tree, state, before);
  }
}

// More partners than the first search keeps, among them exactly as many and one more.
TYPED_TEST(SearchTree, KernelFindsManyPartners) {
  using real = TypeParam;
  for (const u32 n : {16u, 17u, 18u, 300u}) {
    const std::vector<BodyDescription> knot(n, sphere_body({3, 3, 3}, 0.5));
    expect_kernel_matches(Stage::search_tree, with_tree(make_worlds<real>({knot}, n * n)), before);
  }
}

}  // namespace
}  // namespace lockstep::test::search_tree_test
