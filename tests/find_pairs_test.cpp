#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/pair_lists.hpp"

namespace lockstep::test::find_pairs_test {
namespace {

template <class real>
class FindPairs : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(FindPairs, Precisions);

// Every two spheres that touch at some time of the step while they move on straight lines, in long double.
template <class real>
PairList touching_within_the_step(const InitialState<real>& state) {
  PairList pairs;
  const long double h = (long double)state.params.dt * state.params.substeps;
  for (u32 i = 0; i < state.sizes.shapes; ++i) {
    for (u32 j = i + 1; j < state.sizes.shapes; ++j) {
      if (!may_touch(state, i, j)) continue;
      const auto &c = state.buffers.bounds[i].center, &e = state.buffers.bounds[j].center;
      const auto v = center_velocity(state, i), w = center_velocity(state, j);
      const long double d[3] = {(long double)c[0] - e[0], (long double)c[1] - e[1], (long double)c[2] - e[2]};
      const long double u[3] = {(long double)v[0] - w[0], (long double)v[1] - w[1], (long double)v[2] - w[2]};
      const long double uu = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
      const long double du = d[0] * u[0] + d[1] * u[1] + d[2] * u[2];
      const long double t = uu > 0 ? std::clamp(-du / uu, (long double)0, h) : 0;
      long double square = 0;
      for (int k = 0; k < 3; ++k) square += (d[k] + u[k] * t) * (d[k] + u[k] * t);
      const real touching_distance = state.buffers.shapes[i].size[0] + state.buffers.shapes[j].size[0];
      if (std::sqrt(square) <= touching_distance) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

template <class real>
void expect_as_brute_force(InitialState<real>& state, std::size_t at_least) {
  const PairList pairs = found(state), expected = brute_force(state), touching = touching_within_the_step(state);
  EXPECT_EQ(pairs, expected);
  EXPECT_TRUE(std::ranges::includes(pairs, touching));
  EXPECT_GE(touching.size(), at_least);
}

TYPED_TEST(FindPairs, ClusteredSpheresOfMixedSizes) {
  using real = TypeParam;
  Random random(6);
  std::vector<BodyDescription> bodies;
  for (int n = 0; n < 5000; ++n) {
    const double shrink = random.between(0, 1);
    const double radius = 0.01 + 0.49 * shrink * shrink * shrink * shrink;  // 1 : 50
    Vector3 position = random.vector(n % 4 == 0 ? 12 : 3);
    if (n % 4 == 1) position[0] += 8;
    bodies.push_back(sphere_body(position, radius, random.vector(0.5)));
  }
  InitialState<real> state = make_worlds<real>({bodies}, 200000);
  expect_as_brute_force(state, 2000);
}

TYPED_TEST(FindPairs, FastSpheres) {
  using real = TypeParam;
  Random random(7);
  std::vector<BodyDescription> bodies;
  for (int n = 0; n < 1500; ++n)
    bodies.push_back(sphere_body(random.vector(5), random.between(0.05, 0.2), random.vector(n % 15 == 0 ? 300 : 3)));
  InitialState<real> state = make_worlds<real>({bodies}, 200000);
  state.params.substeps = 2;
  expect_as_brute_force(state, 200);
}

// A simple cubic lattice of touching spheres: every number is dyadic, so that the gaps of neighbours are exactly the
// margin, and one step wider they are not.
TYPED_TEST(FindPairs, TiesOfALatticeAreInside) {
  using real = TypeParam;
  const u32 n = 12;
  for (const double spacing : {1.0, 1.25, 1.25 + 1.0 / 64}) {
    std::vector<BodyDescription> bodies;
    for (u32 i = 0; i < n * n * n; ++i)
      bodies.push_back(sphere_body({spacing * (i % n), spacing * (i / n % n) - 4, spacing * (i / n / n) - 4}, 0.5));
    InitialState<real> state = make_worlds<real>({bodies}, 200000);
    state.params.margin = real(0.25);
    const PairList pairs = found(state);
    EXPECT_EQ(pairs, brute_force(state));
    EXPECT_EQ(pairs.size(), spacing > 1.25 ? 0u : 3 * n * n * (n - 1));
  }
}

TYPED_TEST(FindPairs, CoincidentCentresMakeEveryPair) {
  using real = TypeParam;
  const u32 n = 300;
  std::vector<BodyDescription> bodies(n, sphere_body({3, 3, 3}, 0.5));
  InitialState<real> state = make_worlds<real>({bodies}, n * n);
  const PairList pairs = found(state);
  EXPECT_EQ(pairs.size(), n * (n - 1) / 2);
  EXPECT_EQ(pairs, brute_force(state));
}

// Far out the coordinates of cells are coarse, and no pair may be lost for it.
TYPED_TEST(FindPairs, FarFromTheOrigin) {
  using real = TypeParam;
  const double far = sizeof(real) == 4 ? 4e6 : 4e8;
  Random random(8);
  std::vector<BodyDescription> bodies;
  for (int n = 0; n < 600; ++n) {
    Vector3 position = random.vector(4);
    for (double& x : position) x += far;
    bodies.push_back(sphere_body(position, random.between(0.3, 0.5)));
  }
  InitialState<real> state = make_worlds<real>({bodies}, 200000);
  expect_as_brute_force(state, 500);
}

// Relative speed: a cloud that falls as one has no pairs, and two that fly at each other have one.
TYPED_TEST(FindPairs, OnlyRelativeSpeedCounts) {
  using real = TypeParam;
  std::vector<BodyDescription> bodies;
  for (int n = 0; n < 27; ++n)
    bodies.push_back(sphere_body({2.0 * (n % 3), 2.0 * (n / 3 % 3), 2.0 * (n / 9)}, 0.5, {0, 0, -300}));
  InitialState<real> state = make_worlds<real>({bodies}, 1000);
  EXPECT_TRUE(found(state).empty());
  state.buffers.motions[13].v[2] = 300;
  EXPECT_FALSE(found(state).empty());
  EXPECT_EQ(pairs_of(state), brute_force(state));
}

TYPED_TEST(FindPairs, CompoundsFiltersAndImmovables) {
  using real = TypeParam;
  Random random(9);
  std::vector<BodyDescription> bodies;
  for (int n = 0; n < 800; ++n) {
    BodyDescription body = sphere_body(random.vector(4), random.between(0.1, 0.4), random.vector(2));
    body.kind = n % 7 == 0 ? BODY_STATIC : n % 7 == 1 ? BODY_KINEMATIC : BODY_DYNAMIC;
    body.angular_velocity = random.vector(10);
    const ShapeDescription first = body.shapes[0];
    for (int k = 0; k < n % 3; ++k) {
      body.shapes.push_back(first);
      body.shapes.back().offset = random.vector(0.5);
    }
    for (ShapeDescription& shape : body.shapes) {
      shape.category = 1u << random.bits() % 4;
      shape.mask = random.bits() % 16;
    }
    bodies.push_back(body);
  }
  InitialState<real> state = make_worlds<real>({bodies}, 200000);
  expect_as_brute_force(state, 300);
}

// Spheres on, over and below level planes: the gap is z - r, and what falls reaches h |v_z| = v_z / 4 farther.
template <class real>
InitialState<real> spheres_over_planes() {
  BodyDescription lift = plane_body({0, 0, -30});
  lift.kind = BODY_KINEMATIC;
  lift.velocity = {0, 0, 80};
  const std::vector<BodyDescription> bodies = {
      plane_body(),
      sphere_body({0, 0, 0.5}, 0.5),                     // touches
      sphere_body({10, 0, 0.75}, 0.5),                   // at the margin
      sphere_body({20, 0, 0.765625}, 0.5),               // beyond it
      sphere_body({30, 0, 3.75}, 0.5, {9, 9, -12}),      // falls 3 m in the step
      sphere_body({40, 0, 3.765625}, 0.5, {9, 9, -12}),  // not far enough
      sphere_body({50, 0, 3.75}, 0.5, {0, 0, 12}),       // rises
      plane_body({0, 0, -1}),
      sphere_body({60, 0, -8}, 0.5),     // below both
      lift,                              // rises 20 m, to -10
      sphere_body({70, 0, -9.25}, 0.5),  // at the margin of the lift
      sphere_body({80, 0, 20}, 0.5, {0, 0, 0}),
  };
  InitialState<real> state = make_worlds<real>({bodies}, 100);
  state.params.dt = real(0.25);
  state.params.margin = real(0.25);
  return state;
}

TYPED_TEST(FindPairs, PlanesPairWithWhatComesInRange) {
  using real = TypeParam;
  InitialState<real> state = spheres_over_planes<real>();
  EXPECT_EQ(found(state), (PairList{{1, 0}, {2, 0}, {4, 0}, {8, 0}, {8, 7}, {10, 0}, {10, 7}, {10, 9}}));
  expect_kernel_matches(Stage::find_pairs, state, {Stage::update_bounds, Stage::sort_cells});
}

// Long, flat, tiny and huge shapes that turn: the boxes leave out what the spheres would not.
TYPED_TEST(FindPairs, ShapesOfAllKinds) {
  using real = TypeParam;
  InitialState<real> state = make_worlds<real>(worlds_of_all_kinds(), 100000);
  PairList pairs;
  for (const auto& [a, b] : found(state)) {
    if (state.buffers.shape_infos[b].kind != SHAPE_PLANE) pairs.emplace_back(a, b);
  }
  EXPECT_EQ(pairs, brute_force(state));
  EXPECT_GT(pairs.size(), 2000u);
  expect_kernel_matches(Stage::find_pairs, state, {Stage::update_bounds, Stage::sort_cells});
}

// A field of planks a hand's breadth above each other: each meets its two neighbours, and only those.
TYPED_TEST(FindPairs, PlanksMeetTheirNeighboursOnly) {
  using real = TypeParam;
  std::vector<BodyDescription> bodies;
  for (int n = 0; n < 50; ++n) bodies.push_back(box_body({0, 0, 0.125 * n}, {4, 4, 0.0625}));
  InitialState<real> state = make_worlds<real>({bodies}, 10000);
  EXPECT_EQ(found(state).size(), 49u);
  for (Motion<real>& motion : state.buffers.motions) motion.v[0] = 300;  // together
  EXPECT_EQ(found(state).size(), 49u);
}

// Worlds of a batch do not see each other, and each has the pairs it has alone.
TYPED_TEST(FindPairs, AWorldOfABatchHasItsLonePairs) {
  using real = TypeParam;
  std::vector<std::vector<BodyDescription>> worlds;
  for (u32 w = 0; w < 5; ++w) {
    Random random(10 + w);
    worlds.push_back({plane_body()});
    for (u32 n = 0; n < 100 + 50 * w; ++n)
      worlds.back().push_back(sphere_body(random.vector(2), random.between(0.05, 0.1 + 0.1 * w), random.vector(3)));
  }
  InitialState<real> batch = make_worlds<real>(worlds, 200000);
  const PairList all = found(batch);
  PairList lone;
  for (u32 w = 0; w < worlds.size(); ++w) {
    InitialState<real> alone = make_worlds<real>({worlds[w]}, 200000);
    const u32 first = batch.buffers.world_ranges[w].first_shape;
    for (auto [a, b] : found(alone)) lone.emplace_back(first + a, first + b);
  }
  EXPECT_EQ(all, lone);
  EXPECT_GT(all.size(), 500u);
}

TYPED_TEST(FindPairs, TooLittleRoomIsToldAndNothingIsWritten) {
  using real = TypeParam;
  std::vector<BodyDescription> bodies(40, sphere_body({3, 3, 3}, 0.5));
  InitialState<real> state = make_worlds<real>({bodies}, 500);
  state.buffers.pairs.resize(600, {7, 7});  // a guard behind the capacity
  run_reference(state, {Stage::update_bounds, Stage::sort_cells, Stage::find_pairs});
  EXPECT_EQ(state.buffers.counters[COUNTER_STATUS], u32(STATUS_PAIRS_FULL));
  EXPECT_EQ(state.buffers.counters[COUNTER_PAIRS], 0u);
  EXPECT_EQ(state.buffers.counters[COUNTER_PAIRS_NEEDED], 780u);
  for (u32 p = 500; p < 600; ++p) EXPECT_EQ(state.buffers.pairs[p].shape_a, 7u);

  InitialState<real> enough = make_worlds<real>({bodies}, 780);
  EXPECT_EQ(found(enough).size(), 780u);
}

TYPED_TEST(FindPairs, KernelMatchesReference) {
  using real = TypeParam;
  const auto before = {Stage::update_bounds, Stage::sort_cells};
  InitialState<real> state = make_worlds<real>(lively_worlds(), 100000);
  const Buffers<real> after = expect_kernel_matches(Stage::find_pairs, state, before);
  EXPECT_GT(after.counters[COUNTER_PAIRS], 1000u);

  // rows that run over the end of the table, or all through it
  for (const u32 buckets : {1u, 2u, 8u}) {
    state.sizes.buckets = state.params.buckets = buckets;
    resize(state.buffers, state.sizes, state.features);
    const Buffers<real> few = expect_kernel_matches(Stage::find_pairs, state, before);
    EXPECT_EQ(few.counters[COUNTER_PAIRS], after.counters[COUNTER_PAIRS]);
  }
  state.params.pair_capacity = state.sizes.pairs = after.counters[COUNTER_PAIRS] - 1;
  const Buffers<real> full = expect_kernel_matches(Stage::find_pairs, state, before);
  EXPECT_EQ(full.counters[COUNTER_STATUS], u32(STATUS_PAIRS_FULL));
}

// More partners than the first search keeps, among them exactly as many and one more.
TYPED_TEST(FindPairs, KernelFindsManyPartners) {
  using real = TypeParam;
  for (const u32 n : {16u, 17u, 18u, 300u}) {
    const std::vector<BodyDescription> knot(n, sphere_body({3, 3, 3}, 0.5));
    expect_kernel_matches(Stage::find_pairs, make_worlds<real>({knot}, n * n),
                          {Stage::update_bounds, Stage::sort_cells});
  }
}

}  // namespace
}  // namespace lockstep::test::find_pairs_test
