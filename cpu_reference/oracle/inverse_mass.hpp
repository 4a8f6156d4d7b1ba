// M^-1 of the global form by a sparse Cholesky factorisation; of an M that is not quite symmetric, as files of others
// have it, by LU as it stands.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <cmath>
#include <stdexcept>

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

class InverseMass {
 public:
  /// Throws std::runtime_error where M is not positive definite.
  explicit InverseMass(const SparseMatrix& m) : skew_(is_skew(m)) {
    cholesky_.compute(skew_ ? SparseMatrix(0.5 * (m + SparseMatrix(m.transpose()))) : m);
    if (skew_) lu_.compute(m);
    if (cholesky_.info() != Eigen::Success || (skew_ && lu_.info() != Eigen::Success))
      throw std::runtime_error("M is not positive definite");
  }

  /// Whether M is unsymmetric by more than rounding: |a_ij - a_ji| beside sqrt(a_ii a_jj).
  bool skew() const { return skew_; }

  Eigen::VectorXd times(const Eigen::VectorXd& x) const {
    if (skew_) return lu_.solve(x);
    return cholesky_.solve(x);
  }
  SparseMatrix times(const SparseMatrix& x) const {
    if (skew_) return lu_.solve(x);
    return cholesky_.solve(x);
  }

 private:
  static bool is_skew(const SparseMatrix& m) {
    const Eigen::VectorXd size = m.diagonal().cwiseAbs().cwiseSqrt();
    const SparseMatrix skew = m - SparseMatrix(m.transpose());
    for (int k = 0; k < skew.outerSize(); ++k) {
      for (SparseMatrix::InnerIterator entry(skew, k); entry; ++entry) {
        if (std::abs(entry.value()) > 1e-12 * size[entry.row()] * size[entry.col()]) return true;
      }
    }
    return false;
  }

  const bool skew_;
  Eigen::SimplicialLLT<SparseMatrix> cholesky_;
  Eigen::SparseLU<SparseMatrix> lu_;
};

}  // namespace lockstep::oracle
