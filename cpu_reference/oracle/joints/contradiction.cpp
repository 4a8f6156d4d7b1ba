#include "cpu_reference/oracle/joints/contradiction.hpp"

#include <cmath>

namespace lockstep::oracle {

bool proves_contradiction(const GlobalConeProblem& problem, const Eigen::VectorXd& y) {
  using Eigen::VectorXd;
  constexpr double zero = 1e-12, not_zero = 1e-9;
  if (y.size() != problem.g.cols() || y.size() == 0 || !y.allFinite()) return false;
  const VectorXd sums = problem.g * y, largest = VectorXd::Constant(y.size(), y.cwiseAbs().maxCoeff()),
                 sizes = problem.g.cwiseAbs() * largest;
  if ((sums.array().abs() > zero * sizes.array()).any()) return false;
  return std::abs(y.dot(problem.b)) > not_zero * y.cwiseAbs().dot(problem.b.cwiseAbs());
}

}  // namespace lockstep::oracle
