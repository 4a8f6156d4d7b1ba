#include "cpu_reference/oracle/cone/factor.hpp"

#include <Eigen/SparseLU>

#include "cpu_reference/oracle/dense.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A dense factorisation runs several times as fast as a sparse one, entry for entry.
constexpr double dense_from = 0.2;  // share of the triangle that is not zero
constexpr Eigen::Index dense_up_to = 6000;

}  // namespace

ShiftedCholesky::ShiftedCholesky(const ConeProblem& problem) {
  if (problem.velocities && problem.velocities->m.rows() < problem.q.size()) {
    by_velocities_ = true;
    w_ = problem.velocities->m;
    h_ = problem.velocities->h;
    h_t_ = h_.transpose();
    SparseMatrix pattern = w_ + SparseMatrix(h_ * h_t_);
    sparse_cholesky_.analyzePattern(pattern);
    return;
  }
  w_ = problem.w.sparse() - problem.w.skew();
  const Eigen::Index n = w_.rows();
  SparseMatrix identity(n, n);
  identity.setIdentity();
  w_ += 0.0 * identity;  // every diagonal entry is stored
  sparse_cholesky_.analyzePattern(w_);
  const double stored = double(sparse_cholesky_.stored());
  dense_ = n <= dense_up_to && stored > dense_from * 0.5 * double(n) * double(n);
  if (dense_) dense_w_ = w_;
}

bool ShiftedCholesky::factorize(const VectorXd& d) {
  d_ = d;
  if (dense_) {
    MatrixXd shifted = dense_w_;
    shifted.diagonal() += d;
    dense_cholesky_.compute(shifted);
    return dense_cholesky_.info() == Eigen::Success;
  }
  if (by_velocities_) {
    const SparseMatrix scaled = d.cwiseInverse().asDiagonal() * h_t_;
    sparse_cholesky_.factorize(w_ + SparseMatrix(h_ * scaled));
    return sparse_cholesky_.info() == Eigen::Success;
  }
  SparseMatrix shifted = w_;
  shifted.diagonal() += d;
  sparse_cholesky_.factorize(shifted);
  return sparse_cholesky_.info() == Eigen::Success;
}

VectorXd ShiftedCholesky::solve(const VectorXd& b) const {
  if (dense_) return dense_cholesky_.solve(b);
  if (!by_velocities_) return sparse_cholesky_.solve(b);
  const VectorXd y = b.cwiseQuotient(d_), v = sparse_cholesky_.solve(h_ * y);
  return y - (h_t_ * v).cwiseQuotient(d_);
}

bool solve_square(const SparseMatrix& j, const VectorXd& b, VectorXd& x) {
  const Eigen::Index n = j.rows();
  if (n == 0) {
    x.resize(0);
    return true;
  }
  if (n <= 100 || (n <= dense_up_to && double(j.nonZeros()) > 0.1 * double(n) * double(n))) {
    x = solve_by_lu(MatrixXd(j), b);
    return x.allFinite();
  }
  Eigen::SparseLU<SparseMatrix> lu(j);
  if (lu.info() != Eigen::Success) return false;
  x = lu.solve(b);
  return lu.info() == Eigen::Success && x.allFinite();
}

}  // namespace lockstep::oracle
