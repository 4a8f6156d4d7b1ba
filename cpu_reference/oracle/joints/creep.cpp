#include "cpu_reference/oracle/joints/creep.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lockstep::oracle {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double steady = 0.05;       // by how much one step may differ from q times the last
constexpr double worth = 2;           // steps
constexpr double on_boundary = 1e-9;  // of mu r_n
constexpr double worse = 2;           // by what a residual may grow in a leap
constexpr std::uint32_t longest_wait = 64;

// The least t > 0 with |r_t + t d_t| = mu (r_n + t d_n), from inside of the cone.
double distance_to_boundary(const Eigen::Vector3d& r, const Eigen::Vector3d& d, double mu) {
  const double a = d.tail<2>().squaredNorm() - mu * mu * d[0] * d[0];
  const double b = r.tail<2>().dot(d.tail<2>()) - mu * mu * r[0] * d[0];
  const double c = r.tail<2>().squaredNorm() - mu * mu * r[0] * r[0];
  const double tip = d[0] < 0 ? -r[0] / d[0] : infinity;
  if (mu == 0) return tip;
  const double root = b * b - a * c;
  if (root < 0) return tip;
  // c < 0: the roots of a t^2 + 2 b t + c are -c / (b +- sqrt(root))
  const double t = b + std::sqrt(root) > 0 ? -c / (b + std::sqrt(root)) : infinity;
  return std::min(t, tip);
}

}  // namespace

double Creep::room(const VectorXd& x, const VectorXd& step) const {
  double least = infinity;
  for (Index i = 0; i < mu_.size(); ++i) {
    const Eigen::Vector3d r = x.segment<3>(3 * i), d = step.segment<3>(3 * i);
    const double edge = mu_[i] * r[0];
    const bool inside = r[0] > 0 && (mu_[i] == 0 || r.tail<2>().norm() < (1 - on_boundary) * edge);
    if (inside) least = std::min(least, distance_to_boundary(r, d, mu_[i]));
  }
  return least;
}

std::optional<VectorXd> Creep::leap(const VectorXd& x, double residual, std::uint32_t sweeps) {
  const std::uint32_t interval = sweeps - sweeps_;
  const VectorXd step = last_.size() == x.size() ? VectorXd(x - last_) : VectorXd();
  const VectorXd earlier = step_;
  const bool comparable = interval == interval_ && earlier.size() == x.size() && step.size() == x.size();
  last_ = x;
  step_ = step;
  interval_ = interval;
  sweeps_ = sweeps;
  if (leapt_) {
    leapt_ = false;
    step_.resize(0);
    if (residual <= worse * residual_before_) {
      next_wait_ = 1;
      return {};
    }
    waits_ = next_wait_;
    next_wait_ = std::min(2 * next_wait_, longest_wait);
    last_ = before_;
    return before_;
  }
  if (waits_ > 0) {
    --waits_;
    return {};
  }
  if (!comparable || !(earlier.squaredNorm() > 0)) return {};
  const double q = step.dot(earlier) / earlier.squaredNorm();
  if (!(q > 0) || (step - q * earlier).norm() > steady * step.norm()) return {};
  const double times = std::min(q < 1 ? q / (1 - q) : infinity, room(x, step));
  if (!(times > worth) || times == infinity) return {};
  before_ = x;
  residual_before_ = residual;
  leapt_ = true;
  last_ = x + times * step;
  return last_;
}

}  // namespace lockstep::oracle
