#include <gtest/gtest.h>

#include "tests/pair_lists.hpp"

namespace lockstep::test::build_tree_test {
namespace {

template <class real>
class BuildTree : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(BuildTree, Precisions);

const auto before = {Stage::update_bounds, Stage::sort_shapes};

template <class real>
InitialState<real> built(u32 count) {
  Random random(count);
  std::vector<BodyDescription> bodies;
  for (u32 n = 0; n < count; ++n) bodies.push_back(any_body(random, 20, 1));
  InitialState<real> state = with_tree(make_worlds<real>({bodies}, 16));
  run_reference(state, {Stage::update_bounds, Stage::sort_shapes, Stage::build_tree});
  return state;
}

// From the lowest level up: run `e` of PACK^level shapes lies in entry `e`, whole, for the whole step.
TYPED_TEST(BuildTree, EveryLevelContainsItsShapes) {
  using real = TypeParam;
  for (const u32 count : {1u, 15u, 16u, 17u, 256u, 257u, 5000u}) {
    const InitialState<real> state = built<real>(count);
    const Buffers<real>& b = state.buffers;
    const double h = double(state.params.dt) * state.params.substeps;
    u32 first = 0, width = PACK, entries = (count + PACK - 1) / PACK;
    for (;; width *= PACK) {
      const u32 blocks = (entries + PACK - 1) / PACK;
      ASSERT_LE(first + blocks, b.tree_blocks.size());
      for (u32 slot = 0; slot < count; ++slot) {
        const u32 i = b.tree_items[slot], e = slot / width;
        const BoxBlock<real>& block = b.tree_blocks[first + e / PACK];
        const real* low[] = {block.low_x, block.low_y, block.low_z};
        const real* high[] = {block.high_x, block.high_y, block.high_z};
        for (u32 k = 0; k < 3; ++k) {
          const double from = b.bounds[i].center[k], to = from + h * double(b.motions[i].v[k]),
                       box = b.bounds[i].box[k];
          EXPECT_LE(low[k][e % PACK], std::min(from, to) - box);
          EXPECT_GE(high[k][e % PACK], std::max(from, to) + box);
        }
      }
      for (u32 e = entries; e < blocks * PACK; ++e)
        EXPECT_GT(b.tree_blocks[first + e / PACK].low_x[e % PACK], b.tree_blocks[first + e / PACK].high_x[e % PACK]);
      first += blocks;
      if (entries <= PACK) break;
      entries = blocks;
    }
    EXPECT_EQ(first, b.tree_blocks.size());
  }
}

TYPED_TEST(BuildTree, KernelMatchesReference) {
  using real = TypeParam;
  for (const auto& worlds : {lively_worlds(), worlds_of_all_kinds()}) {
    InitialState<real> state = with_tree(make_worlds<real>(worlds, 1000));
    state.buffers.positions[50].y = std::numeric_limits<real>::quiet_NaN();
    expect_kernel_matches(Stage::build_tree, state, before);
  }
  for (const u32 count : {1u, 17u, 257u, 4097u}) expect_kernel_matches(Stage::build_tree, built<real>(count), before);
}

}  // namespace
}  // namespace lockstep::test::build_tree_test
