// Follows an iteration: measures each iterate that it is shown, keeps the best, and says when to stop.
#pragma once

#include <chrono>

#include "cpu_reference/oracle/error.hpp"
#include "cpu_reference/oracle/solve.hpp"

namespace lockstep::oracle {

/// Of iterates of any kind, which come with their residual.
class Progress {
 public:
  /// `patience`: looks without a gain of a hundredth after which it has stalled.
  Progress(const SolveLimits& limits, std::uint32_t patience);

  /// Takes note of the iterate after `iterations` iterations; true where to stop.
  bool look(const Eigen::VectorXd& x, double residual, std::uint32_t iterations);

  /// Whether an iterate is worth looking at: every so often only, so that a cheap iteration is not mostly measuring.
  bool is_due(std::uint32_t iterations);

  double residual() const { return last_; }  // of the last look
  double best_residual() const { return report_.residual; }
  const Eigen::VectorXd& best() const { return best_; }

  /// Of a method that does not know how to go on.
  void stop_stalled() { report_.stop = Stop::stalled; }

  /// To be called once: gives the best iterate seen and the report.
  SolveReport finish(Eigen::VectorXd& x);

 private:
  double seconds() const;

  using Clock = std::chrono::steady_clock;
  const Clock::time_point start_ = Clock::now();
  const SolveLimits limits_;
  const std::uint32_t patience_;
  SolveReport report_;
  Eigen::VectorXd best_;
  double last_ = 0, gained_at_ = 0;
  std::uint32_t looks_since_gain_ = 0, next_look_ = 1;
};

/// Of the impulses of a problem without joints.
class Watch : public Progress {
 public:
  /// The problem must outlive it.
  Watch(const ConeProblem& problem, const SolveLimits& limits, std::uint32_t patience = 400)
      : Progress(limits, patience), problem_(problem), meter_(problem) {}

  bool look(const Eigen::VectorXd& r, std::uint32_t iterations) {
    return Progress::look(r, meter_.residual(r, problem_.w.times(r) + problem_.q), iterations);
  }
  /// The same of an iterate that is_due(), and false of others.
  bool look_seldom(const Eigen::VectorXd& r, std::uint32_t iterations) {
    return is_due(iterations) && look(r, iterations);
  }

  const ResidualMeter& meter() const { return meter_; }

 private:
  const ConeProblem& problem_;
  const ResidualMeter meter_;
};

}  // namespace lockstep::oracle
