// What a solver that promises a residual, or a tolerance, did not keep of it.
#pragma once

#include <array>
#include <string>

#include "host/stop.hpp"
#include "kernels/types.h"

namespace lockstep {

/// The sub-steps that did not end as solved, how many in each way, and which was the first and which the worst. Of
/// oracles (docs/solvers_oracle.md), and of solvers with a tolerance that used up their sweeps; one that is to make so
/// many sweeps promises nothing and leaves nothing unsolved. A step that failed counts once, as bad, whatever its
/// sub-steps came to.
struct Unsolved {
  u32 count = 0;
  std::array<u32, stop_count> ended = {};    // of each Stop; of `solved` none are counted
  u32 first_step = 0, worst_step = 0;        // steps count from 0
  Stop first_stop = {}, worst_stop = {};     // how the solver ended there
  double worst_residual = 0, tolerance = 0;  // what was left, and what was asked for
  bool of_changes = false;  // that is a change of velocity in a sweep, m/s, and what was left is not known

  /// So many sub-steps of one step, of which the worst left this residual.
  static Unsolved of(u32 sub_steps, u32 step, Stop stop, double residual, double tolerance) {
    Unsolved all;
    all.count = all.ended[static_cast<u32>(stop)] = sub_steps;
    all.first_step = all.worst_step = step;
    all.first_stop = all.worst_stop = stop;
    all.worst_residual = residual;
    all.tolerance = tolerance;
    return all;
  }

  /// Adds those of a later part of the same run.
  void add(const Unsolved& later) {
    if (later.count == 0) return;
    const bool is_first = count == 0, is_worse = is_first || later.is_worse_than(*this);
    count += later.count;
    for (u32 stop = 0; stop < stop_count; ++stop) ended[stop] += later.ended[stop];
    if (is_first) {
      first_step = later.first_step;
      first_stop = later.first_stop;
    }
    if (!is_worse) return;
    worst_step = later.worst_step;
    worst_stop = later.worst_stop;
    worst_residual = later.worst_residual;
    tolerance = later.tolerance;
    of_changes = later.of_changes;
  }

 private:
  // What is no number is worse than any number.
  bool is_worse_than(const Unsolved& other) const {
    const bool bad = worst_stop == Stop::bad, other_bad = other.worst_stop == Stop::bad;
    if (bad || other_bad) return bad && !other_bad;
    return worst_residual > other.worst_residual;
  }
};

/// "nsgs left 3 sub-steps unsolved (2 at its limit, 1 stalled), the first in step 4 (limit), the worst in step 7
/// (stalled): a residual of 2e-09, not 1e-10".
std::string in_words(const std::string& solver, const Unsolved& unsolved);

}  // namespace lockstep
