// The frame of every solver: the clock, the history, the best iterate of an iteration; the scaling of a direct method.
#pragma once

#include <chrono>

#include "cpu_reference/oracle/lcp/lcp.hpp"

namespace lockstep::oracle::lcp {

/// Watches an iteration: keeps its history and its best iterate, and says when to stop and why.
class Watch {
 public:
  template <class Problem>
  Watch(const Problem& problem, const SolveLimits& limits)
      : started_(std::chrono::steady_clock::now()), limits_(limits), measure_(problem) {}

  /// The iterate before the first iteration. Says whether it will do.
  bool start(const VectorXd& z);

  /// The iterate after one more iteration. Says whether to stop: it is good enough, the limits are reached, or the best
  /// residual has not fallen by a hundredth in the last 1000 iterations (a stall; divergence is one).
  bool stop_after(const VectorXd& z);

  /// Ends the iteration from within, for a reason of the method's own.
  void end(Stop why) { report_.stop = why; }

  /// The report; `z` becomes the best iterate.
  SolveReport finish(VectorXd& z);

  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count(); }
  const Measure& measure() const { return measure_; }

 private:
  std::chrono::steady_clock::time_point started_;
  SolveLimits limits_;
  Measure measure_;
  SolveReport report_;
  VectorXd best_;
  double milestone_ = 0;  // the residual that has to be undercut, and when it was set
  std::uint32_t milestone_set_ = 0;
};

/// `z` where it fits, 0 where not.
void start_from(VectorXd& z, Index size);

/// A direct method works on S M S x = -S q / U with S = natural_scale, U = max |S q|: its zeros are relative to 1.
/// It counts its pivots, and at the end hands over what it found.
class DirectSolve {
 public:
  DirectSolve(const Lcp& problem, const SolveLimits& limits);

  const Lcp& scaled() const { return scaled_; }
  double zero() const { return zero_; }  // what is not above it is rounding, in the scaled problem

  /// Counts a pivot; false where no more is allowed.
  bool may_pivot();
  std::uint32_t pivots() const { return pivots_; }
  double unit() const { return unit_; }  // U
  double seconds() const;

  /// `x` solves the scaled problem as far as rounding allows; its positive entries are solved for once more, from the
  /// matrix itself, and the better of the two is taken. `otherwise` says why the method stopped if that is no solution.
  SolveReport finish(VectorXd x, Stop otherwise, VectorXd& z);

 private:
  std::chrono::steady_clock::time_point started_;
  SolveLimits limits_;
  Measure measure_;
  Lcp scaled_;
  double unit_ = 1, zero_ = 0;
  std::uint32_t pivots_ = 0;
};

}  // namespace lockstep::oracle::lcp
