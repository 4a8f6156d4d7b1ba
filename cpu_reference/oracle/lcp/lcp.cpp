#include "cpu_reference/oracle/lcp/lcp.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/error.hpp"

namespace lockstep::oracle::lcp {

namespace {

double largest(const VectorXd& x) { return x.size() > 0 ? x.cwiseAbs().maxCoeff() : 0; }

[[noreturn]] void refuse(const std::string& what) { throw Error(Failure::input, "complementarity problem", what); }

void check(const MatrixXd& m, const VectorXd& q) {
  if (m.rows() != q.size() || m.cols() != q.size()) {
    refuse("a vector of " + std::to_string(q.size()) + " asks for a square matrix of that size, not " +
           std::to_string(m.rows()) + " x " + std::to_string(m.cols()));
  }
  if (!m.allFinite() || !q.allFinite()) refuse("a number is not finite");
}

void check(const BoxedLcp& p) {
  check(p.m, p.q);
  const Index n = p.size();
  if (p.low.size() != n || p.high.size() != n || Index(p.normal.size()) != n || p.friction.size() != n)
    refuse("its bounds are of another size than its matrix");
  for (Index i = 0; i < n; ++i) {
    const std::string row = "row " + std::to_string(i) + ": ";
    if (!(p.low[i] <= p.high[i])) refuse(row + "its lower bound is above its upper one");
    if (p.normal[i] < -1 || p.normal[i] >= n || p.normal[i] == i) refuse(row + "there is no such normal");
    if (p.normal[i] >= 0 && p.normal[p.normal[i]] >= 0) refuse(row + "its normal is bounded by another row itself");
    if (!(p.friction[i] >= 0) || p.friction[i] == infinity) refuse(row + "friction must be at least 0, and finite");
  }
}

}  // namespace

bool BoxedLcp::has_friction() const {
  return std::any_of(normal.begin(), normal.end(), [](Index n) { return n >= 0; });
}

double BoxedLcp::low_at(Index i, const VectorXd& z) const {
  return normal[i] < 0 ? low[i] : -friction[i] * std::max(0.0, z[normal[i]]);
}

double BoxedLcp::high_at(Index i, const VectorXd& z) const {
  return normal[i] < 0 ? high[i] : friction[i] * std::max(0.0, z[normal[i]]);
}

BoxedLcp boxed(const Lcp& problem) {
  const Index n = problem.size();
  return {problem.m,
          problem.q,
          VectorXd::Zero(n),
          VectorXd::Constant(n, infinity),
          std::vector<Index>(static_cast<std::size_t>(n), -1),
          VectorXd::Zero(n)};
}

VectorXd natural_scale(const MatrixXd& m) {
  const Index n = m.rows();
  VectorXd s = VectorXd::Zero(n);
  for (Index i = 0; i < n; ++i) {
    if (m(i, i) != 0) s[i] = 1 / std::sqrt(std::abs(m(i, i)));
  }
  const VectorXd known = s;
  for (Index i = 0; i < n; ++i) {
    if (known[i] > 0) continue;
    const double row = (m.row(i).transpose().cwiseAbs().cwiseProduct(known)).maxCoeff();
    const double column = (m.col(i).cwiseAbs().cwiseProduct(known)).maxCoeff();
    const double coupling = std::max(row, column);
    s[i] = coupling > 0 ? 1 / coupling : 1;
  }
  return s;
}

Measure::Measure(const Lcp& problem) : m_(problem.m), q_(problem.q) {
  check(m_, q_);
  scale_ = natural_scale(m_);
  unit_ = largest(natural_map(VectorXd::Zero(q_.size())));
  if (unit_ == 0) unit_ = largest(scale_.cwiseProduct(q_));
}

Measure::Measure(const BoxedLcp& problem) : m_(problem.m), q_(problem.q), box_(&problem) {
  check(problem);
  scale_ = natural_scale(m_);
  unit_ = largest(natural_map(VectorXd::Zero(q_.size())));
  if (unit_ == 0) unit_ = largest(scale_.cwiseProduct(q_));
}

VectorXd Measure::natural_map(const VectorXd& z) const {
  const VectorXd w = m_ * z + q_;
  VectorXd f(z.size());
  for (Index i = 0; i < z.size(); ++i) {
    const double s = scale_[i], size = z[i] / s;
    const double low = box_ ? box_->low_at(i, z) / s : 0, high = box_ ? box_->high_at(i, z) / s : infinity;
    f[i] = size - std::clamp(size - s * w[i], low, high);
  }
  return f;
}

double Measure::operator()(const VectorXd& z) const {
  if (!z.allFinite()) return infinity;
  const double defect = largest(natural_map(z));
  if (defect == 0) return 0;
  return defect / (unit_ > 0 ? unit_ : largest(z.cwiseQuotient(scale_)));
}

double residual(const Lcp& problem, const VectorXd& z) { return Measure(problem)(z); }
double residual(const BoxedLcp& problem, const VectorXd& z) { return Measure(problem)(z); }

}  // namespace lockstep::oracle::lcp
