#include <gtest/gtest.h>

#include "tests/bodies.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::end_step_test {
namespace {

TEST(EndStep, CountsAStep) {
  InitialState<float> state = make_bodies<float>({BodySetup{}}, {});
  state.buffers.step_index[0] = 41;
  EXPECT_EQ(run_stage(Stage::end_step, state).step_index[0], 42u);
}

TEST(EndStep, CountsAStepThatWentBad) {
  InitialState<float> state = make_bodies<float>({BodySetup{}}, {});
  state.buffers.counters[COUNTER_STATUS] = STATUS_BAD_POSE;
  EXPECT_EQ(run_stage(Stage::end_step, state).step_index[0], 1u);
}

TEST(EndStep, DoesNotCountAStepThatWillBeRedone) {
  for (const u32 full : {STATUS_PAIRS_FULL, STATUS_CONTACTS_FULL, STATUS_BLOCKS_FULL}) {
    InitialState<float> state = make_bodies<float>({BodySetup{}}, {});
    state.buffers.counters[COUNTER_STATUS] = full | STATUS_BAD_FORCES;
    EXPECT_EQ(run_stage(Stage::end_step, state).step_index[0], 0u);
  }
}

TEST(EndStep, KernelMatchesReference) {
  for (const u32 status : {0u, u32{STATUS_BAD_POSE}, u32{STATUS_PAIRS_FULL}}) {
    InitialState<float> state = make_bodies<float>({BodySetup{}}, {});
    state.buffers.step_index[0] = 41;
    state.buffers.counters[COUNTER_STATUS] = status;
    run_one_stage(Stage::end_step, state.buffers, state.sizes, state.features, state.params);
  }
}

}  // namespace
}  // namespace lockstep::end_step_test
