#include "cpu_reference/oracle/lcp/watch.hpp"

#include <algorithm>
#include <cmath>

#include "cpu_reference/oracle/dense.hpp"
#include "host/stop_request.hpp"

namespace lockstep::oracle::lcp {

namespace {

constexpr std::uint32_t patience = 1000;  // iterations
constexpr double gain = 0.99;

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// M_AA x_A = -q_A with A = { i | x_i > 0 }.
VectorXd solve_again(const Lcp& p, const VectorXd& x) {
  std::vector<Index> a;
  for (Index i = 0; i < x.size(); ++i) {
    if (x[i] > 0) a.push_back(i);
  }
  VectorXd again = VectorXd::Zero(x.size());
  if (!a.empty()) again(a) = solve_by_lu(p.m(a, a), VectorXd(-p.q(a)));
  return again.cwiseMax(0);
}

}  // namespace

bool Watch::start(const VectorXd& z) {
  report_.residual = milestone_ = measure_(z);
  best_ = z;
  if (report_.residual <= limits_.tolerance) report_.stop = Stop::solved;
  return report_.stop == Stop::solved;
}

bool Watch::stop_after(const VectorXd& z) {
  const double current = measure_(z);
  ++report_.iterations;
  report_.residuals.push_back(current);
  if (current < report_.residual) {
    report_.residual = current;
    best_ = z;
  }
  if (report_.residual < gain * milestone_) {
    milestone_ = report_.residual;
    milestone_set_ = report_.iterations;
  }
  if (report_.residual <= limits_.tolerance) {
    report_.stop = Stop::solved;
  } else if (!std::isfinite(report_.residual)) {
    report_.stop = Stop::bad;
  } else if (!z.allFinite() || report_.iterations - milestone_set_ >= patience) {
    report_.stop = Stop::stalled;
  } else if (stop_asked() || report_.iterations >= limits_.iterations || seconds() > limits_.seconds) {
    report_.stop = Stop::limit;
  } else {
    return false;
  }
  return true;
}

SolveReport Watch::finish(VectorXd& z) {
  z = best_;
  report_.seconds = seconds();
  return report_;
}

void start_from(VectorXd& z, Index size) {
  if (z.size() != size || !z.allFinite()) z = VectorXd::Zero(size);
}

DirectSolve::DirectSolve(const Lcp& problem, const SolveLimits& limits)
    : started_(Clock::now()), limits_(limits), measure_(problem) {
  const VectorXd& s = measure_.scale();
  scaled_ = {s.asDiagonal() * problem.m * s.asDiagonal(), s.cwiseProduct(problem.q)};
  if (problem.size() > 0 && scaled_.q.cwiseAbs().maxCoeff() > 0) unit_ = scaled_.q.cwiseAbs().maxCoeff();
  scaled_.q /= unit_;
  zero_ = std::clamp(limits.tolerance / 100, 1e-14, 1e-10);
}

double DirectSolve::seconds() const { return since(started_); }

bool DirectSolve::may_pivot() {
  if (stop_asked() || pivots_ >= limits_.iterations || since(started_) > limits_.seconds) return false;
  ++pivots_;
  return true;
}

SolveReport DirectSolve::finish(VectorXd x, Stop otherwise, VectorXd& z) {
  const auto unscaled = [&](const VectorXd& y) { return VectorXd(unit_ * y.cwiseProduct(measure_.scale())); };
  SolveReport report;
  report.iterations = pivots_;
  z = unscaled(x);
  report.residual = measure_(z);
  const VectorXd again = unscaled(solve_again(scaled_, x));
  if (const double better = measure_(again); better < report.residual) {
    z = again;
    report.residual = better;
  }
  report.stop = report.residual <= limits_.tolerance ? Stop::solved
                : !std::isfinite(report.residual)    ? Stop::bad
                                                     : otherwise;
  report.seconds = since(started_);
  return report;
}

}  // namespace lockstep::oracle::lcp
