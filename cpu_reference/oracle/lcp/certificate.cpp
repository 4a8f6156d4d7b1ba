#include "cpu_reference/oracle/lcp/certificate.hpp"

#include <algorithm>
#include <cmath>

namespace lockstep::oracle::lcp {

bool proves_infeasible(const Lcp& p, const VectorXd& low, const VectorXd& high, VectorXd y) {
  constexpr double zero = 1e-11, below_zero = 1e-6;
  const double largest = y.size() > 0 ? y.cwiseAbs().maxCoeff() : 0;
  if (!(largest > 0) || !std::isfinite(largest)) return false;
  y /= largest;
  for (Index i = 0; i < y.size(); ++i) {
    if (std::abs(y[i]) <= zero) y[i] = 0;
    if ((y[i] > 0 && std::isfinite(high[i])) || (y[i] < 0 && std::isfinite(low[i]))) return false;
  }
  const VectorXd c = p.m.transpose() * y, sizes = p.m.cwiseAbs().transpose() * y.cwiseAbs();
  double most = p.q.dot(y), size = p.q.cwiseAbs().dot(y.cwiseAbs());
  for (Index i = 0; i < y.size(); ++i) {
    if (std::abs(c[i]) <= zero * sizes[i]) continue;
    const double bound = c[i] > 0 ? high[i] : low[i];
    if (!std::isfinite(bound)) return false;
    most += c[i] * bound;
    size += std::abs(c[i] * bound);
  }
  return most < -below_zero * size;
}

bool proves_infeasible(const Lcp& p, const VectorXd& y) {
  return proves_infeasible(p, VectorXd::Zero(y.size()), VectorXd::Constant(y.size(), infinity), y);
}

}  // namespace lockstep::oracle::lcp
