#include "cpu_reference/oracle/dense.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

namespace lockstep::oracle {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd product(const MatrixXd& a, const MatrixXd& b) { return a * b; }

MatrixXd transposed_product(const MatrixXd& a, const MatrixXd& b) { return a.transpose() * b; }

VectorXd solve_by_lu(const MatrixXd& a, const VectorXd& b) { return Eigen::PartialPivLU<MatrixXd>(a).solve(b); }

MatrixXd solve_by_lu(const MatrixXd& a, const MatrixXd& b) { return Eigen::PartialPivLU<MatrixXd>(a).solve(b); }

std::optional<VectorXd> solve_if_regular(const MatrixXd& a, const VectorXd& b, double regular) {
  const Eigen::FullPivLU<MatrixXd> lu(a);
  if (!lu.isInvertible() || !(lu.rcond() > regular)) return {};
  return lu.solve(b);
}

VectorXd solve_by_least_norm(const MatrixXd& a, const VectorXd& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

VectorXd solve_or_least_norm(const MatrixXd& a, const VectorXd& b, double regular) {
  const Eigen::PartialPivLU<MatrixXd> lu(a);
  if (lu.rcond() > regular) return lu.solve(b);
  return solve_by_least_norm(a, b);
}

VectorXd solve_by_least_squares(const MatrixXd& a, const VectorXd& b) { return a.colPivHouseholderQr().solve(b); }

std::optional<MatrixXd> inverse_if_regular(const MatrixXd& a) {
  const Eigen::FullPivLU<MatrixXd> lu(a);
  if (!lu.isInvertible()) return {};
  return lu.inverse();
}

RankAndInverse rank_and_inverse(const MatrixXd& a, double zero) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(a);
  qr.setThreshold(zero);
  if (qr.rank() < a.rows()) return {qr.rank(), {}};
  return {qr.rank(), qr.inverse()};
}

template <int Size>
SymmetricEigen<Size> symmetric_eigen(const Eigen::Matrix<double, Size, Size>& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, Size, Size>> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}
template SymmetricEigen<2> symmetric_eigen(const Eigen::Matrix2d& a);
template SymmetricEigen<3> symmetric_eigen(const Eigen::Matrix3d& a);
template SymmetricEigen<Eigen::Dynamic> symmetric_eigen(const MatrixXd& a);

MatrixXd pseudo_inverse(const MatrixXd& a, double zero) {
  if (a.size() == 0) return a;
  const SymmetricEigen<Eigen::Dynamic> eigen = symmetric_eigen<Eigen::Dynamic>(a);
  const double least = zero * eigen.values.lpNorm<Eigen::Infinity>();
  const VectorXd inverse = (eigen.values.array() > least).select(eigen.values.cwiseInverse(), 0);
  return product(eigen.vectors * inverse.asDiagonal(), eigen.vectors.transpose());
}

double largest_eigenvalue(const Matrix3d& a) {
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(a, Eigen::EigenvaluesOnly).eigenvalues()(2);
}

}  // namespace lockstep::oracle
