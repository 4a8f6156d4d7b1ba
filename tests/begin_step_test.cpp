#include <gtest/gtest.h>

#include "tests/bodies.hpp"

namespace lockstep {
namespace {

TEST(BeginStep, ClearsWhateverTheLastStepLeft) {
  InitialState<float> state = make_bodies<float>({BodySetup{}}, {});
  state.buffers.counters.assign(COUNTER_COUNT, 0xdeadbeefu);
  const Buffers<float> after = run_stage(Stage::begin_step, state);
  EXPECT_EQ(after.counters, std::vector<u32>(COUNTER_COUNT, 0u));
}

}  // namespace
}  // namespace lockstep
