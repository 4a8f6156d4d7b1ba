// Factorisations of W with something on its diagonal: sparse where that stays sparse, else dense, which then is faster.
#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

/// Cholesky factorisation of the symmetric part of W + diag(d), d > 0, for several d.
class ShiftedCholesky {
 public:
  explicit ShiftedCholesky(const BlockMatrix& w);

  /// False where it is not positive definite, as far as rounding lets see.
  bool factorize(const Eigen::VectorXd& d);
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

 private:
  SparseMatrix w_;
  bool dense_ = false;
  Eigen::SimplicialLLT<SparseMatrix> sparse_cholesky_;
  Eigen::MatrixXd dense_w_;
  Eigen::LLT<Eigen::MatrixXd> dense_cholesky_;
};

/// Solves J x = b by LU with pivoting. False where that broke down.
bool solve_square(const SparseMatrix& j, const Eigen::VectorXd& b, Eigen::VectorXd& x);

}  // namespace lockstep::oracle
