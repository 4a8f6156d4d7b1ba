#include <gtest/gtest.h>

#include "tests/bodies.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::begin_step_test {
namespace {

TEST(BeginStep, ClearsWhateverTheLastStepLeft) {
  InitialState<float> state = make_bodies<float>({BodySetup{}}, {});
  state.buffers.counters.assign(COUNTER_COUNT, 0xdeadbeefu);
  const Buffers<float> after = run_stage(Stage::begin_step, state);
  EXPECT_EQ(after.counters, std::vector<u32>(COUNTER_COUNT, 0u));
}

TEST(BeginStep, KernelMatchesReference) {
  InitialState<float> state = make_bodies<float>({BodySetup{}}, {});
  state.buffers.counters.assign(COUNTER_COUNT, 0xdeadbeefu);
  run_one_stage(Stage::begin_step, state.buffers, state.sizes, state.features, state.params);
}

}  // namespace
}  // namespace lockstep::begin_step_test
