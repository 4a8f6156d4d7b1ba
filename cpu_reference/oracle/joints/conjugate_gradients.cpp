// Joints by conjugate gradients (survey 4.2.2: "sub-blocks") in the form that makes |c - R x| least in each step,
// conjugate residuals (Stiefel 1955; Saad, Iterative Methods for Sparse Linear Systems, 2003, section 6.8). It takes a
// singular R as it is, and ends where what is left has become the part of c that no impulses change:
//   z . R z <= 1e-11 lambda z . r,   z = P^-1 r,   lambda: the largest such quotient seen;
// conjugate gradients go on from there, to impulses without bounds. P^-1 is the inverse of each joint's own block of R,
// or P an incomplete Cholesky factorisation (Lin and More, Incomplete Cholesky factorizations with limited memory,
// 1999; Eigen).
#include <Eigen/IterativeLinearSolvers>
#include <algorithm>
#include <cmath>

#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/joints/joint_solver.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index rounds_of_residuals = 2;  // of as many steps as there are rows

// As Eigen wants a preconditioner to look like.
class JointBlocks {
 public:
  using StorageIndex = int;
  enum { ColsAtCompileTime = Eigen::Dynamic, MaxColsAtCompileTime = Eigen::Dynamic };

  void set_blocks(std::vector<std::uint32_t> first) { first_ = std::move(first); }

  template <class Matrix>
  JointBlocks& analyzePattern(const Matrix&) {
    return *this;
  }
  template <class Matrix>
  JointBlocks& compute(const Matrix& r) {
    return factorize(r);
  }
  template <class Matrix>
  JointBlocks& factorize(const Matrix& r) {
    inverse_.clear();
    for (std::size_t block = 0; block + 1 < first_.size(); ++block) {
      const Index first = first_[block], size = first_[block + 1] - first;
      // what says nothing new in a joint's own block says nothing in R
      inverse_.push_back(pseudo_inverse(MatrixXd(r.block(first, first, size, size)), 1e-12));
    }
    return *this;
  }

  template <class Vector>
  VectorXd solve(const Vector& b) const {
    VectorXd x(b.size());
    for (std::size_t block = 0; block < inverse_.size(); ++block) {
      const Index first = first_[block], size = inverse_[block].rows();
      x.segment(first, size).noalias() = inverse_[block].lazyProduct(b.segment(first, size));
    }
    return x;
  }
  Eigen::ComputationInfo info() const { return Eigen::Success; }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<MatrixXd> inverse_;
};

template <class Preconditioner>
class ConjugateResiduals final : public JointSolver {
 public:
  template <class Prepare>
  ConjugateResiduals(const GlobalConeProblem& problem, double accuracy, Prepare&& prepare)
      : r_(joint_mobility(problem)), accuracy_(accuracy) {
    prepare(preconditioner_);
    preconditioner_.compute(r_);
  }

  VectorXd solve(const VectorXd& c) const override {
    VectorXd x = VectorXd::Zero(c.size()), left = c, z = inverse(left), r_z = r_ * z, p = z, r_p = r_z;
    double bend = z.dot(r_z), largest = 0;
    for (Index k = 0; k < rounds_of_residuals * c.size() && left.norm() > accuracy_ * c.norm(); ++k) {
      const double size = z.dot(left);
      if (size > 0) largest = std::max(largest, bend / size);
      if (!(bend > redundant_rows * largest * size)) break;  // what is left no impulses change
      const VectorXd answer = inverse(r_p);
      const double step = bend / r_p.dot(answer);
      if (!std::isfinite(step)) break;
      x += step * p;
      left -= step * r_p;
      z -= step * answer;
      r_z = r_ * z;
      const double next = z.dot(r_z), turn = next / bend;
      p = z + turn * p;
      r_p = r_z + turn * r_p;
      bend = next;
    }
    return x;
  }

 private:
  VectorXd inverse(const VectorXd& c) const { return preconditioner_.solve(c); }

  const SparseMatrix r_;
  const double accuracy_;
  Preconditioner preconditioner_;
};

}  // namespace

std::unique_ptr<JointSolver> make_pcg(const GlobalConeProblem& problem, double accuracy) {
  return std::make_unique<ConjugateResiduals<JointBlocks>>(
      problem, accuracy, [&](JointBlocks& blocks) { blocks.set_blocks(joint_blocks(problem)); });
}

std::unique_ptr<JointSolver> make_ichol(const GlobalConeProblem& problem, double accuracy) {
  return std::make_unique<ConjugateResiduals<Eigen::IncompleteCholesky<double>>>(problem, accuracy, [](auto&) {});
}

}  // namespace lockstep::oracle
