#include "cpu_reference/oracle/articulated/reduced_pyramid.hpp"

#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/models/friction_pyramid.hpp"

namespace lockstep::oracle::articulated {

ReducedPyramid::ReducedPyramid(const ReducedProblem& problem, int directions)
    : problem_(problem), directions_(directions) {
  const Eigen::Matrix2Xd circle = models::pyramid_directions(directions);
  const Index n = problem.contacts(), dry = problem.drives(), bounds = problem.bounds();
  const Index alpha_dry = n, alpha = alpha_dry + 2 * dry, beta = alpha + n * directions_, bound = beta + dry + n;
  spread_ = MatrixXd::Zero(problem.size(), bound + bounds);
  for (Index i = 0; i < n; ++i) {
    spread_(3 * i, i) = 1;
    spread_.block(3 * i + 1, alpha + i * directions_, 2, directions_) = circle;
  }
  for (Index k = 0; k < dry; ++k) {
    spread_(problem.first_drive() + k, alpha_dry + 2 * k) = 1;
    spread_(problem.first_drive() + k, alpha_dry + 2 * k + 1) = -1;
  }
  for (Index k = 0; k < bounds; ++k) spread_(problem.first_bound() + k, bound + k) = 1;
}

MatrixXd ReducedPyramid::couplings() const {
  return models::pyramid_couplings(problem_.friction, problem_.drives(), directions_, size());
}

VectorXd ReducedPyramid::constants() const {
  VectorXd a = VectorXd::Zero(size());
  a.segment(problem_.contacts() + 2 * problem_.drives() + problem_.contacts() * directions_, problem_.drives()) =
      problem_.max_impulse;
  return a;
}

lcp::Lcp ReducedPyramid::lcp() const {
  const MatrixXd w = transposed_product(spread_, problem_.w * spread_);
  return {couplings() + w, constants() + spread_.transpose() * problem_.q};
}

}  // namespace lockstep::oracle::articulated
