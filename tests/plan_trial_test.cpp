// The trial keeps the faster plan, whatever comes between, and tries again where the scene has changed.
#include "host/backends/plan_trial.hpp"

#include <gtest/gtest.h>

namespace lockstep::plan_trial_test {
namespace {

// Runs steps that take so long by each plan; how many took the second one.
u32 run(PlanTrial& trial, u32 steps, double first, double second, u32 contacts = 1000) {
  u32 taken = 0;
  for (u32 i = 0; i < steps; ++i) {
    taken += trial.plan();
    trial.note(trial.plan() == 0 ? first : second, contacts);
  }
  return taken;
}

TEST(PlanTrial, KeepsTheFasterPlan) {
  PlanTrial one, other;
  EXPECT_EQ(run(one, 200, 1, 0.6), 4u + 192u);
  EXPECT_EQ(run(other, 200, 0.6, 1), 4u);
}

TEST(PlanTrial, LeavesAHopelessPlanAtOnce) {
  PlanTrial trial;
  EXPECT_EQ(run(trial, 200, 1, 50), 1u);
}

TEST(PlanTrial, OneSlowStepDecidesNothing) {
  PlanTrial trial;
  run(trial, 3, 1, 0.6);
  trial.note(3, 1000);  // the machine was at other work
  EXPECT_EQ(run(trial, 200, 1, 0.6), 2u + 196u);
}

TEST(PlanTrial, TriesAgainWithOtherContacts) {
  PlanTrial trial;
  run(trial, 150, 1, 0.6, 1000);
  EXPECT_EQ(trial.plan(), 1u);
  run(trial, 50, 0.6, 1, 3000);
  EXPECT_EQ(trial.plan(), 0u);
}

TEST(PlanTrial, TriesAgainWhereStepsStaySlow) {
  PlanTrial trial;
  run(trial, 150, 1, 0.6);
  EXPECT_EQ(trial.plan(), 1u);
  run(trial, 50, 1, 5);
  EXPECT_EQ(trial.plan(), 0u);
}

}  // namespace
}  // namespace lockstep::plan_trial_test
