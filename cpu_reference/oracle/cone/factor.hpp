// Factorisations of W with something on its diagonal: sparse where that stays sparse, else dense, which then is faster.
#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

/// Eigen's factorisation, which tells how full it becomes before it is made.
struct SparseCholesky : Eigen::SimplicialLLT<SparseMatrix> {
  Eigen::Index stored() const { return m_matrix.nonZeros(); }
};

/// Cholesky factorisation of the symmetric part of W + D, D = diag(d) > 0, for several d. Where W = H^T M^-1 H is known
/// and there are fewer velocities than rows, by Woodbury's formula
///   (W + D)^-1 = D^-1 - D^-1 H^T (M + H D^-1 H^T)^-1 H D^-1.
class ShiftedCholesky {
 public:
  explicit ShiftedCholesky(const ConeProblem& problem);

  /// False where it is not positive definite, as far as rounding lets see.
  bool factorize(const Eigen::VectorXd& d);
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

 private:
  bool by_velocities_ = false, dense_ = false;
  SparseMatrix w_;        // or M
  SparseMatrix h_, h_t_;  // H and its transpose
  Eigen::VectorXd d_;
  SparseCholesky sparse_cholesky_;
  Eigen::MatrixXd dense_w_;
  Eigen::LLT<Eigen::MatrixXd> dense_cholesky_;
};

/// Solves J x = b by LU with pivoting. False where that broke down.
bool solve_square(const SparseMatrix& j, const Eigen::VectorXd& b, Eigen::VectorXd& x);

}  // namespace lockstep::oracle
