// The tests of the grid (find_pairs_test.cpp) hold the comparison of all shapes to the same pairs; here are what only
// it is asked, and the kernel.
#include <gtest/gtest.h>

#include "tests/pair_lists.hpp"

namespace lockstep::test::compare_shapes_test {
namespace {

template <class real>
class CompareShapes : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CompareShapes, Precisions);

// Far out shapes have no cell of the grid, and are compared like others.
TYPED_TEST(CompareShapes, FindsWhatHasNoCell) {
  using real = TypeParam;
  InitialState<real> state = with_comparison(
      make_worlds<real>({{sphere_body({1e12, 0, 0}, 0.5), sphere_body({0, 0, 0}, 0.5), sphere_body({1e12, 0, 0}, 0.5),
                          sphere_body({0.9, 0, 0}, 0.5), plane_body({0, 0, -0.4})}},
                        100));
  run_reference(state, {Stage::update_bounds, Stage::compare_shapes});
  EXPECT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
  EXPECT_EQ(pairs_of(state), (PairList{{0, 2}, {0, 4}, {1, 3}, {1, 4}, {2, 4}, {3, 4}}));
}

TYPED_TEST(CompareShapes, KernelMatchesReference) {
  using real = TypeParam;
  for (const auto& worlds : {lively_worlds(), worlds_of_all_kinds()}) {
    InitialState<real> state = with_comparison(make_worlds<real>(worlds, 100000));
    state.buffers.positions[50].y = std::numeric_limits<real>::quiet_NaN();
    const Buffers<real> after = expect_kernel_matches(Stage::compare_shapes, state, {Stage::update_bounds});
    EXPECT_GT(after.counters[COUNTER_PAIRS], 1000u);
    state.params.pair_capacity = state.sizes.pairs = after.counters[COUNTER_PAIRS] - 1;
    const Buffers<real> full = expect_kernel_matches(Stage::compare_shapes, state, {Stage::update_bounds});
    EXPECT_NE(full.counters[COUNTER_STATUS] & STATUS_PAIRS_FULL, 0u);
  }
}

// More partners than the first search keeps, among them exactly as many and one more; and runs of lanes that end
// anywhere.
TYPED_TEST(CompareShapes, KernelFindsManyPartners) {
  using real = TypeParam;
  for (const u32 n : {1u, 2u, 16u, 17u, 18u, 31u, 300u}) {
    const std::vector<BodyDescription> knot(n, sphere_body({3, 3, 3}, 0.5));
    const Buffers<real> after = expect_kernel_matches(
        Stage::compare_shapes, with_comparison(make_worlds<real>({knot, knot}, n * n + 1)), {Stage::update_bounds});
    EXPECT_EQ(after.counters[COUNTER_PAIRS], n * (n - 1));
  }
}

}  // namespace
}  // namespace lockstep::test::compare_shapes_test
