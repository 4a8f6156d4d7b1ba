#include <gtest/gtest.h>

#include <cmath>

#include "tests/collision_states.hpp"

namespace lockstep::test::sort_cells_test {
namespace {

template <class real>
class SortCells : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SortCells, Precisions);

template <class real>
void expect_sorted(const InitialState<real>& state) {
  const Buffers<real>& b = state.buffers;
  std::vector<u32> seen(state.sizes.shapes, 0);
  ASSERT_EQ(b.bucket_starts[0], 0u);
  for (u32 k = 0; k < state.sizes.buckets; ++k) {
    for (u32 n = b.bucket_starts[k]; n < b.bucket_starts[k + 1]; ++n) {
      const u32 i = b.bucket_items[n];
      EXPECT_EQ(b.cells[i].bucket, k);
      if (n > b.bucket_starts[k]) {
        EXPECT_LT(b.bucket_items[n - 1], i);
      }
      ++seen[i];
    }
  }
  for (u32 i = 0; i < state.sizes.shapes; ++i) EXPECT_EQ(seen[i], b.cells[i].bucket == NONE ? 0u : 1u);
  for (u32 n = b.bucket_starts[state.sizes.buckets]; n < state.sizes.shapes; ++n) EXPECT_EQ(b.bucket_items[n], NONE);
}

// The cell of a shape holds its centre, and two spheres that could touch lie in cells that touch.
TYPED_TEST(SortCells, EachSphereIsInTheListOfItsCell) {
  using real = TypeParam;
  Random random(5);
  std::vector<BodyDescription> bodies;
  bodies.push_back(plane_body());
  bodies.push_back(sphere_body({0, 0, 0}, 0.5));  // the largest: it sizes the cells
  for (int n = 0; n < 3000; ++n)
    bodies.push_back(sphere_body(random.vector(n % 3 == 0 ? 1 : 10), random.between(0.01, 0.5)));
  InitialState<real> state = make_worlds<real>({bodies}, 16);
  run_reference(state, {Stage::update_bounds, Stage::sort_cells});
  expect_sorted(state);
  const Buffers<real>& b = state.buffers;
  EXPECT_EQ(b.cells[0].bucket, NONE);
  const double size = 2 * 0.5 + 0.005;
  for (u32 i = 1; i < state.sizes.shapes; ++i) {
    EXPECT_NEAR((b.cells[i].x + 0.5) * size, b.bounds[i].center[0], 0.5 * size * 1.01);
    EXPECT_NEAR((b.cells[i].y + 0.5) * size, b.bounds[i].center[1], 0.5 * size * 1.01);
    EXPECT_NEAR((b.cells[i].z + 0.5) * size, b.bounds[i].center[2], 0.5 * size * 1.01);
  }
  EXPECT_EQ(b.counters[COUNTER_STATUS], 0u);
}

TYPED_TEST(SortCells, NegativeCoordinatesRoundDown) {
  using real = TypeParam;
  InitialState<real> state =
      make_worlds<real>({{sphere_body({-0.25, 0.25, -1.25}, 0.5), sphere_body({0, 0, 0}, 0.125)}}, 16);
  run_reference(state, {Stage::update_bounds, Stage::sort_cells});
  EXPECT_EQ(state.buffers.cells[0].x, -1);
  EXPECT_EQ(state.buffers.cells[0].y, 0);
  EXPECT_EQ(state.buffers.cells[0].z, -2);
}

// A batch of equal worlds, all at the origin: the world is part of the hash, and the lists stay short.
TYPED_TEST(SortCells, WorldsAtOnePositionDoNotShareABucket) {
  using real = TypeParam;
  std::vector<std::vector<BodyDescription>> worlds(1000, {sphere_body({0, 0, 0}, 0.5)});
  InitialState<real> state = make_worlds<real>(worlds, 16);
  run_reference(state, {Stage::update_bounds, Stage::sort_cells});
  expect_sorted(state);
  u32 longest = 0;
  for (u32 k = 0; k < state.sizes.buckets; ++k)
    longest = std::max(longest, state.buffers.bucket_starts[k + 1] - state.buffers.bucket_starts[k]);
  EXPECT_LE(longest, 8u);
}

TYPED_TEST(SortCells, ASphereThatIsTooFarOutIsNamed) {
  using real = TypeParam;
  std::vector<BodyDescription> bodies(4, sphere_body({0, 0, 0}, 0.5));
  bodies[1].position = {0, -1e12, 0};
  bodies[2].position = {1e25, 0, 0};
  InitialState<real> state = make_worlds<real>({bodies}, 16);
  run_reference(state, {Stage::update_bounds, Stage::sort_cells});
  expect_sorted(state);
  EXPECT_EQ(state.buffers.counters[COUNTER_STATUS], u32(STATUS_OUT_OF_GRID));
  EXPECT_EQ(NONE - state.buffers.counters[COUNTER_BAD_BODY], 1u);
  EXPECT_EQ(state.buffers.cells[1].bucket, NONE);
  EXPECT_EQ(state.buffers.cells[2].bucket, NONE);
  EXPECT_NE(state.buffers.cells[3].bucket, NONE);
}

TYPED_TEST(SortCells, KernelMatchesReference) {
  using real = TypeParam;
  InitialState<real> state = make_worlds<real>(lively_worlds(), 1000);
  expect_kernel_matches(Stage::sort_cells, state, {Stage::update_bounds});
  state.buffers.positions[100].x = real(1e20);
  state.buffers.positions[50].y = real(-1e12);
  expect_kernel_matches(Stage::sort_cells, state, {Stage::update_bounds});
}

// All in one bucket, so many that threads arrive in turns, and more buckets than one work-group scans.
TYPED_TEST(SortCells, KernelSortsLongLists) {
  using real = TypeParam;
  const std::vector<BodyDescription> knot(50000, sphere_body({3, 3, 3}, 0.5));
  InitialState<real> state = make_worlds<real>({knot}, 16);
  state.sizes.buckets = state.params.buckets = 16384;
  resize(state.buffers, state.sizes, state.features);
  expect_kernel_matches(Stage::sort_cells, state, {Stage::update_bounds});
}

}  // namespace
}  // namespace lockstep::test::sort_cells_test
