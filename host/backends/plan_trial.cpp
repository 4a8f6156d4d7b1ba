#include "host/backends/plan_trial.hpp"

#include <algorithm>

namespace lockstep {

void PlanTrial::begin() {
  step_ = slow_ = 0;
  least_ = {1e300, 1e300};
}

void PlanTrial::note(double seconds, u32 contacts) {
  const u32 plan = this->plan();
  if (in_trial()) {
    const bool warm = step_ % steps_each != 0;
    if (warm) least_[plan] = std::min(least_[plan], seconds);
    ++step_;
    const bool hopeless = seconds > 4 * least_[1 - plan];
    if (hopeless) step_ = rounds * steps_each;
    if (in_trial()) return;
    best_ = hopeless ? 1 - plan : least_[1] < least_[0];
    contacts_ = contacts;
    return;
  }
  slow_ = seconds > 2 * least_[best_] ? slow_ + 1 : 0;
  const bool differs = contacts > contacts_ + contacts_ / 2 + PACK || contacts + contacts / 2 + PACK < contacts_;
  if (++step_ > steps_between_trials && (differs || slow_ >= slow_steps)) begin();
}

}  // namespace lockstep
