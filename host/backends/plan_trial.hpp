// Which of two plans for the same step is the faster one, by the clock. No bit depends on the plan, so that nothing but
// speed depends on the answer.
#pragma once

#include <array>

#include "kernels/types.h"

namespace lockstep {

/// Takes plans in turn for a few steps, keeps the faster one, and tries again once there are half as many contacts more
/// or fewer, or steps have become twice as slow. A trial ends at once with a plan that takes four times as long.
class PlanTrial {
 public:
  /// 0 or 1: how to run the next step.
  u32 plan() const { return in_trial() ? step_ / steps_each % 2 : best_; }
  /// What the step took that was run so, s, and how many contacts it had. The first step of a trial's round warms up.
  void note(double seconds, u32 contacts);

 private:
  static constexpr u32 steps_each = 2, rounds = 4, steps_between_trials = 100, slow_steps = 8;

  bool in_trial() const { return step_ < rounds * steps_each; }
  void begin();

  u32 best_ = 0, step_ = 0;                       // of the trial, then of what follows
  std::array<double, 2> least_ = {1e300, 1e300};  // s
  u32 contacts_ = 0;                              // at the end of the trial
  u32 slow_ = 0;                                  // steps one behind the other that took twice as long
};

}  // namespace lockstep
