// Linear algebra of dense matrices of any size: what several oracles ask of Eigen. Its decompositions and blocked
// products are templates that are compiled again in every file that names them; here they are compiled once.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace lockstep::oracle {

/// a b, and a^T b. The inner sizes agree; 0 of them gives zeros.
Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::MatrixXd transposed_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// x with a x = b, a square and not empty, by LU with partial pivoting. Where a is singular x is not finite, or, as
/// rounding has it, very large.
Eigen::VectorXd solve_by_lu(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd solve_by_lu(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The same by LU with full pivoting; nothing where the reciprocal condition number of a is not above `regular`.
std::optional<Eigen::VectorXd> solve_if_regular(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double regular);

/// The x of least norm among those that make |a x - b| least, a of any shape and rank, by a complete orthogonal
/// decomposition.
Eigen::VectorXd solve_by_least_norm(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// solve_by_lu where the reciprocal condition number of a (square, not empty) is above `regular`, else
/// solve_by_least_norm.
Eigen::VectorXd solve_or_least_norm(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double regular);

/// An x that makes |a x - b| least, by QR with column pivoting; 0 in columns that say nothing new.
Eigen::VectorXd solve_by_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// The inverse of a square matrix by LU with full pivoting; nothing where it is singular, as far as rounding lets see.
std::optional<Eigen::MatrixXd> inverse_if_regular(const Eigen::MatrixXd& a);

/// The rank of a square matrix by QR with column pivoting, a pivot up to `zero` times the largest counting as 0, and
/// its inverse where that is full; elsewhere the inverse is empty.
struct RankAndInverse {
  Eigen::Index rank = 0;
  Eigen::MatrixXd inverse;
};
RankAndInverse rank_and_inverse(const Eigen::MatrixXd& a, double zero);

/// Eigenvalues of a symmetric matrix, rising, and eigenvectors of length 1 in columns. The lower triangle counts.
template <int Size>
struct SymmetricEigen {
  Eigen::Matrix<double, Size, 1> values;
  Eigen::Matrix<double, Size, Size> vectors;
};
template <int Size>
SymmetricEigen<Size> symmetric_eigen(const Eigen::Matrix<double, Size, Size>& a);  // Size: 2, 3 or Eigen::Dynamic

/// The pseudo-inverse of a symmetric matrix; eigenvalues up to `zero` times the largest in size count as 0, and so do
/// those below 0. The lower triangle counts.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a, double zero);

/// The largest eigenvalue of a symmetric matrix; the lower triangle counts.
double largest_eigenvalue(const Eigen::Matrix3d& a);

}  // namespace lockstep::oracle
