#include "cpu_reference/oracle/cone/watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/stop_request.hpp"

namespace lockstep::oracle {

Progress::Progress(const SolveLimits& limits, std::uint32_t patience) : limits_(limits), patience_(patience) {
  report_.residual = gained_at_ = std::numeric_limits<double>::infinity();
}

double Progress::seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

bool Progress::look(const Eigen::VectorXd& x, double residual, std::uint32_t iterations) {
  last_ = residual;
  report_.iterations = iterations;
  report_.residuals.push_back(last_);
  if (last_ < report_.residual || best_.size() == 0) {
    report_.residual = last_;
    best_ = x;
  }
  ++looks_since_gain_;
  if (report_.residual < 0.99 * gained_at_) {
    gained_at_ = report_.residual;
    looks_since_gain_ = 0;
  }
  if (report_.residual <= limits_.tolerance) {
    report_.stop = Stop::solved;
    return true;
  }
  if (!std::isfinite(last_)) {
    report_.stop = std::isfinite(report_.residual) ? Stop::stalled : Stop::bad;  // it went back to what it had
    return true;
  }
  if (looks_since_gain_ >= patience_) {
    report_.stop = Stop::stalled;
    return true;
  }
  report_.stop = Stop::limit;
  return stop_asked() || iterations >= limits_.iterations || seconds() >= limits_.seconds;
}

bool Progress::is_due(std::uint32_t iterations) {
  if (iterations < next_look_ && iterations < limits_.iterations && !stop_asked()) return false;
  next_look_ = iterations + std::clamp(iterations / 10, 1u, 50u);
  return true;
}

SolveReport Progress::finish(Eigen::VectorXd& x) {
  if (best_.size() > 0) x = best_;
  report_.seconds = seconds();
  return report_;
}

}  // namespace lockstep::oracle
