// Follows an iteration: measures each iterate that it is shown, keeps the best, and says when to stop.
#pragma once

#include <chrono>

#include "cpu_reference/oracle/error.hpp"
#include "cpu_reference/oracle/solve.hpp"

namespace lockstep::oracle {

class Watch {
 public:
  /// `patience`: looks without a gain of a hundredth after which it has stalled. The problem must outlive it.
  Watch(const ConeProblem& problem, const SolveLimits& limits, std::uint32_t patience);

  /// Takes note of the iterate after `iterations` iterations; true where to stop.
  bool look(const Eigen::VectorXd& r, std::uint32_t iterations);

  /// An iterate that is worth looking at every so often only, so that a cheap iteration is not mostly measuring.
  bool look_seldom(const Eigen::VectorXd& r, std::uint32_t iterations);

  const ResidualMeter& meter() const { return meter_; }
  double residual() const { return last_; }  // of the last look
  double best_residual() const { return report_.residual; }
  const Eigen::VectorXd& best() const { return best_; }

  /// Of a method that does not know how to go on.
  void give_up() { report_.stop = Stop::stall; }

  /// To be called once: gives the best iterate seen and the report.
  SolveReport finish(Eigen::VectorXd& r);

 private:
  double seconds() const;

  using Clock = std::chrono::steady_clock;
  const Clock::time_point start_ = Clock::now();
  const ConeProblem& problem_;
  const SolveLimits limits_;
  const std::uint32_t patience_;
  const ResidualMeter meter_;
  SolveReport report_;
  Eigen::VectorXd best_;
  double last_ = 0, gained_at_ = 0;
  std::uint32_t looks_since_gain_ = 0, next_look_ = 1;
};

}  // namespace lockstep::oracle
