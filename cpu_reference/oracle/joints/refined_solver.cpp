#include "cpu_reference/oracle/joints/refined_solver.hpp"

#include <stdexcept>

namespace lockstep::oracle {

using Eigen::Index;
using Eigen::VectorXd;

RefinedSolver::RefinedSolver(const GlobalConeProblem& problem, double accuracy)
    : accuracy_(accuracy), r_(joint_mobility(problem)), scale_(inverse_roots(r_.diagonal())) {
  r_ = scale_.asDiagonal() * r_ * scale_.asDiagonal();
}

void RefinedSolver::choose_shift(double slight) {
  constexpr double wide = 1e-6;
  const double largest = r_.cols() > 0 ? VectorXd(r_.cwiseAbs() * VectorXd::Ones(r_.cols())).maxCoeff() : 1;  // a bound
  if (prepare(slight * largest) && least_eigenvalue() > redundant_rows * largest) return;
  shift_ = wide * largest;
  if (!prepare(shift_)) throw std::runtime_error("the joints' rows cannot be factorised");
}

// As far as inverse iteration gets; where it is rounding it may come out below 0.
double RefinedSolver::least_eigenvalue() const {
  constexpr int iterations = 4;
  VectorXd x(r_.rows());
  for (Index i = 0; i < x.size(); ++i) x[i] = 1 + double((i * 7919) % 101) / 101;  // along no vector in particular
  for (int k = 0; k < iterations; ++k) {
    x = inverse(x.normalized());
    if (!x.allFinite()) return 0;
  }
  x.normalize();
  return x.dot(r_ * x);
}

VectorXd RefinedSolver::solve(const VectorXd& c) const {
  const VectorXd scaled = scale_.cwiseProduct(c);
  return scale_.cwiseProduct(refined(shift_ > 0 ? VectorXd(scaled - in_null_space(scaled)) : scaled));
}

VectorXd RefinedSolver::beyond(const VectorXd& c) const {
  if (shift_ == 0) return VectorXd::Zero(c.size());
  return scale_.cwiseProduct(in_null_space(scale_.cwiseProduct(c)));
}

// Goes on while half of it vanishes a time.
VectorXd RefinedSolver::in_null_space(const VectorXd& c) const {
  constexpr int most = 30, sure = 4;
  VectorXd y = c;
  for (int k = 0; k < most && y.norm() > 1e-16 * c.norm(); ++k) {
    const double before = y.norm();
    y = shift_ * inverse(y);
    if (k >= sure && y.norm() > 0.5 * before) break;
  }
  return y;
}

// Each refinement has to halve what is left.
VectorXd RefinedSolver::refined(const VectorXd& c) const {
  constexpr int most = 30;
  VectorXd x = VectorXd::Zero(c.size()), left = c;
  for (int k = 0; k < most && left.norm() > accuracy_ * c.norm(); ++k) {
    const VectorXd next = x + inverse(left), still = c - r_ * next;
    if (!(still.norm() < (k == 0 ? 1 : 0.5) * left.norm())) break;
    x = next;
    left = still;
  }
  return x;
}

}  // namespace lockstep::oracle
