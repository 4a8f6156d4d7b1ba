// Joints by an inverse that is not quite that of R. Whether R is singular, as redundant rows make it, its least
// eigenvalue tells, which inverse iteration finds: where it is, a single solve turns any vector into its null space.
// Then R + delta is inverted, which is regular however many rows are redundant. What c has of the null space of R no x
// can meet; it is found as what stays of
//   y <- delta (R + delta)^-1 y
// while the rest vanishes by delta / (eigenvalue + delta) a time, and c is solved for without it. Of an eigenvalue far
// below delta, that of rows that have drifted, x gets no more than the square of eigenvalue / delta.
// Rows are scaled to a mobility of 1, so that masses and units do not matter to what is redundant.
#pragma once

#include "cpu_reference/oracle/joints/joint_solver.hpp"

namespace lockstep::oracle {

class RefinedSolver : public JointSolver {
 public:
  Eigen::VectorXd solve(const Eigen::VectorXd& c) const override;
  Eigen::VectorXd beyond(const Eigen::VectorXd& c) const override;

 protected:
  /// `accuracy`: of |c - R x| / |c|, where refinement ends.
  RefinedSolver(const GlobalConeProblem& problem, double accuracy);

  /// R with scaled rows.
  const SparseMatrix& mobility() const { return r_; }
  /// Prepares the inverse: with a delta of `slight` parts of the largest eigenvalue, or, where R is singular, of 1e-6.
  /// Throws std::runtime_error where it cannot be prepared.
  void choose_shift(double slight);

 private:
  /// Makes inverse() that of R + delta; false where it cannot be had.
  virtual bool prepare(double delta) = 0;
  virtual Eigen::VectorXd inverse(const Eigen::VectorXd& c) const = 0;
  double least_eigenvalue() const;
  Eigen::VectorXd refined(const Eigen::VectorXd& c) const;
  Eigen::VectorXd in_null_space(const Eigen::VectorXd& c) const;

  const double accuracy_;
  SparseMatrix r_;
  Eigen::VectorXd scale_;
  double shift_ = 0;  // delta, where R is singular
};

}  // namespace lockstep::oracle
