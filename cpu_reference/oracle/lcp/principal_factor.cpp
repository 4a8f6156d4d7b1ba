#include "cpu_reference/oracle/lcp/principal_factor.hpp"

#include <Eigen/Jacobi>
#include <cmath>

namespace lockstep::oracle::lcp {

PrincipalFactor::PrincipalFactor(const MatrixXd& m, double zero)
    : m_(m), zero_(zero), symmetric_(m.isApprox(m.transpose(), 1e-13)), triangle_(MatrixXd::Zero(m.rows(), m.rows())) {
  if (!symmetric_) orthogonal_ = MatrixXd::Zero(m.rows(), m.rows());
}

bool PrincipalFactor::append(Index i) {
  const bool regular = symmetric_ ? append_to_cholesky(i) : append_to_qr(i);
  if (regular) set_.push_back(i);
  return regular;
}

void PrincipalFactor::remove(Index position) {
  symmetric_ ? remove_from_cholesky(position) : remove_from_qr(position);
  set_.erase(set_.begin() + position);
}

VectorXd PrincipalFactor::solve(const VectorXd& b) const {
  const auto t = triangle_.topLeftCorner(size(), size());
  if (symmetric_) return t.triangularView<Eigen::Lower>().adjoint().solve(t.triangularView<Eigen::Lower>().solve(b));
  return t.triangularView<Eigen::Upper>().solve(orthogonal_.topLeftCorner(size(), size()).transpose() * b);
}

// [ M_AA c; c^T m ] = [ L 0; l^T d ] [ L^T l; 0 d ]   with   L l = c,  d^2 = m - l . l.
bool PrincipalFactor::append_to_cholesky(Index i) {
  const Index k = size();
  const VectorXd l = triangle_.topLeftCorner(k, k).triangularView<Eigen::Lower>().solve(VectorXd(m_(set_, i)));
  const double pivot = m_(i, i) - l.squaredNorm();
  if (pivot <= zero_) return false;
  triangle_.row(k).head(k) = l;
  triangle_(k, k) = std::sqrt(pivot);
  return true;
}

// Without row p the rows below it reach one column too far; rotations of neighbouring columns take that away.
void PrincipalFactor::remove_from_cholesky(Index p) {
  const Index k = size() - 1;
  for (Index i = p; i < k; ++i) triangle_.row(i).head(i + 2) = triangle_.row(i + 1).head(i + 2);
  for (Index j = p; j < k; ++j) {
    const double a = triangle_(j, j), b = triangle_(j, j + 1), r = std::hypot(a, b);
    const Eigen::JacobiRotation<double> rotation(a / r, -b / r);
    auto below = triangle_.middleRows(j, k - j);
    below.applyOnTheRight(j, j + 1, rotation);
    triangle_(j, j + 1) = 0;
  }
  triangle_.col(k).setZero();
  triangle_.row(k).setZero();
}

// [ Q 0; 0 1 ] [ R Q^T c; b^T m ]: rotations of each row with the last one make the right factor a triangle again.
bool PrincipalFactor::append_to_qr(Index i) {
  const Index k = size();
  const VectorXd c = orthogonal_.topLeftCorner(k, k).transpose() * VectorXd(m_(set_, i));
  const Eigen::RowVectorXd b = m_(i, set_);
  const VectorXd x = triangle_.topLeftCorner(k, k).triangularView<Eigen::Upper>().solve(c);
  if (std::abs(m_(i, i) - b.dot(x)) <= zero_) return false;

  triangle_.col(k).head(k) = c;
  triangle_.row(k).head(k) = b;
  triangle_(k, k) = m_(i, i);
  orthogonal_.row(k).head(k).setZero();
  orthogonal_.col(k).head(k).setZero();
  orthogonal_(k, k) = 1;
  for (Index j = 0; j < k; ++j) {
    const double a = triangle_(j, j), low = triangle_(k, j), r = std::hypot(a, low);
    if (low == 0) continue;
    const Eigen::JacobiRotation<double> rotation(a / r, -low / r);
    auto right = triangle_.middleCols(j, k + 1 - j);
    right.applyOnTheLeft(j, k, rotation.transpose());
    triangle_(k, j) = 0;
    auto rows = orthogonal_.topRows(k + 1);
    rows.applyOnTheRight(j, k, rotation);
  }
  return true;
}

// The column leaves a Hessenberg matrix, which rotations make a triangle; then rotations of rows turn row p of Q into
// a unit vector, whose row of R belongs to the row of M that leaves.
void PrincipalFactor::remove_from_qr(Index p) {
  const Index k = size();
  auto q = orthogonal_.topLeftCorner(k, k);
  auto r = triangle_.topLeftCorner(k, k);
  for (Index j = p; j + 1 < k; ++j) r.col(j) = r.col(j + 1).eval();
  r.col(k - 1).setZero();
  const auto rotate = [&](Index j, double a, double b) {  // of rows j, j + 1: (a, b) becomes (|(a, b)|, 0)
    const double size = std::hypot(a, b);
    if (b == 0) return;
    const Eigen::JacobiRotation<double> rotation(a / size, -b / size);
    r.applyOnTheLeft(j, j + 1, rotation.transpose());
    q.applyOnTheRight(j, j + 1, rotation);
  };
  for (Index j = p; j + 1 < k; ++j) {
    rotate(j, r(j, j), r(j + 1, j));
    r(j + 1, j) = 0;
  }
  for (Index j = k - 2; j >= 0; --j) rotate(j, q(p, j), q(p, j + 1));

  for (Index i = p; i + 1 < k; ++i) q.row(i) = q.row(i + 1).eval();
  for (Index j = 0; j + 1 < k; ++j) q.col(j) = q.col(j + 1).eval();
  for (Index i = 0; i + 1 < k; ++i) r.row(i) = r.row(i + 1).eval();
  r.row(k - 1).setZero();
}

}  // namespace lockstep::oracle::lcp
