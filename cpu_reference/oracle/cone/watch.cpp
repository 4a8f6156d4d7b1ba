#include "cpu_reference/oracle/cone/watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lockstep::oracle {

Watch::Watch(const ConeProblem& problem, const SolveLimits& limits, std::uint32_t patience)
    : problem_(problem), limits_(limits), patience_(patience), meter_(problem) {
  report_.residual = gained_at_ = std::numeric_limits<double>::infinity();
}

double Watch::seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

bool Watch::look(const Eigen::VectorXd& r, std::uint32_t iterations) {
  last_ = meter_.residual(r, problem_.w.times(r) + problem_.q);
  report_.iterations = iterations;
  report_.residuals.push_back(last_);
  if (last_ < report_.residual || best_.size() == 0) {
    report_.residual = last_;
    best_ = r;
  }
  ++looks_since_gain_;
  if (report_.residual < 0.99 * gained_at_) {
    gained_at_ = report_.residual;
    looks_since_gain_ = 0;
  }
  if (report_.residual <= limits_.tolerance) {
    report_.stop = Stop::tolerance;
    return true;
  }
  if (looks_since_gain_ >= patience_ || !std::isfinite(last_)) {
    report_.stop = Stop::stall;
    return true;
  }
  report_.stop = Stop::limit;
  return iterations >= limits_.iterations || seconds() >= limits_.seconds;
}

bool Watch::look_seldom(const Eigen::VectorXd& r, std::uint32_t iterations) {
  if (iterations < next_look_ && iterations < limits_.iterations) return false;
  next_look_ = iterations + std::clamp(iterations / 10, 1u, 50u);
  return look(r, iterations);
}

SolveReport Watch::finish(Eigen::VectorXd& r) {
  if (best_.size() > 0) r = best_;
  report_.seconds = seconds();
  return report_;
}

}  // namespace lockstep::oracle
