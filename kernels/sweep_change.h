// By how much a sweep still changes velocities, where a tolerance ends the sweeps of a sub-step
// (cpu_reference/solve_constraints.hpp). The largest change of a sweep is a maximum of words, so that neither the order
// of the solves nor who makes them matters.
#ifndef LOCKSTEP_SWEEP_CHANGE_H
#define LOCKSTEP_SWEEP_CHANGE_H

#include "common.h"
#include "lanes.h"

// Once a sweep has settled, those behind it in the sub-step do nothing either.
#if FEATURE_TOLERANCE
#define SWEEP_SKIPPED(counters) (STEP_ABORTED(counters) || (counters)[COUNTER_SETTLED] != 0u)
#else
#define SWEEP_SKIPPED(counters) STEP_ABORTED(counters)
#endif

#if FEATURE_TOLERANCE

// Of squared changes, m^2/s^2.
static inline void note_change(lane squared, global u32* counters) {
  const float change = (float)sqrt(lane_largest(squared));
  if (change > 0.0f) atomic_max(&counters[COUNTER_SWEEP_CHANGE], as_uint(change));
}

static inline bool sweep_has_settled(real tolerance, global const u32* counters) {
  return (real)as_float(counters[COUNTER_SWEEP_CHANGE]) <= tolerance;
}

// One work-group, behind a whole sweep: counts it; true where it was the last. `is_last`: there are no more, and where
// it did not settle either, the sub-step is left unsolved.
static inline bool group_has_settled(const real tolerance, const bool is_last, global u32* counters) {
  TEAM_BARRIER(counters);
  const bool settled = sweep_has_settled(tolerance, counters);
  TEAM_BARRIER(counters);
  if (TEAM_ITEM == 0u && !STEP_ABORTED(counters)) {
    counters[COUNTER_SWEEPS] += 1u;
    counters[COUNTER_SWEEP_CHANGE] = 0u;
    if (is_last && !settled) counters[COUNTER_UNSOLVED] += 1u;
  }
  TEAM_BARRIER(counters);
  return settled;
}

#endif

#endif
