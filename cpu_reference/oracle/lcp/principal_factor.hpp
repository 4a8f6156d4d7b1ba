// Solves M_AA x = b for a set A that gains or loses one index at a time, each change in O(|A|^2): what a pivoting
// method asks for (survey 4.1). A symmetric M has a Cholesky factor that is bordered, and retriangularised by rotations
// when a row leaves; any other a QR factorisation changed by rotations (Golub, Van Loan, "Matrix Computations", 6.5).
#pragma once

#include "cpu_reference/oracle/lcp/lcp.hpp"

namespace lockstep::oracle::lcp {

class PrincipalFactor {
 public:
  /// `m` is kept by reference. Pivots up to `zero` count as 0; the diagonal of `m` is to be of size 1.
  PrincipalFactor(const MatrixXd& m, double zero);

  const std::vector<Index>& set() const { return set_; }  // A, in the order in which it grew
  Index size() const { return Index(set_.size()); }

  /// Takes i into A. False, and nothing done, where M_AA would become singular (a symmetric one: not positive
  /// definite).
  bool append(Index i);

  /// Drops the index at this position of `set()`.
  void remove(Index position);

  /// M_AA^-1 b, in the order of `set()`.
  VectorXd solve(const VectorXd& b) const;

 private:
  bool append_to_cholesky(Index i);
  void remove_from_cholesky(Index position);
  bool append_to_qr(Index i);
  void remove_from_qr(Index position);

  const MatrixXd& m_;
  double zero_;
  bool symmetric_;
  std::vector<Index> set_;
  MatrixXd triangle_;    // L (lower) of L L^T, or R (upper) of Q R; its top left corner counts
  MatrixXd orthogonal_;  // Q
};

}  // namespace lockstep::oracle::lcp
