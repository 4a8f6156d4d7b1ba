// Joints by conjugate gradients (survey 4.2.2: "sub-blocks"). A singular R they take as it is only as long as c lies in
// its range; what c has beside it they follow to impulses without bounds. So they solve for R + delta
// (refined_solver.hpp). Preconditioned by the inverse of each joint's own block, or by an incomplete Cholesky
// factorisation (Lin and More, Incomplete Cholesky factorizations with limited memory, 1999; Eigen).
#include <Eigen/IterativeLinearSolvers>

#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/joints/refined_solver.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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
class ConjugateGradients final : public RefinedSolver {
 public:
  template <class Set>
  ConjugateGradients(const GlobalConeProblem& problem, double accuracy, Set&& set) : RefinedSolver(problem, accuracy) {
    set(gradients_.preconditioner());
    gradients_.setTolerance(accuracy);
    choose_shift(1e-10);
  }

 private:
  bool prepare(double delta) override {
    shifted_ = mobility();
    for (Index i = 0; i < shifted_.cols(); ++i) shifted_.coeffRef(i, i) += delta;
    shifted_.makeCompressed();
    gradients_.compute(shifted_);
    return true;
  }
  VectorXd inverse(const VectorXd& c) const override { return gradients_.solve(c); }

  SparseMatrix shifted_;
  Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower | Eigen::Upper, Preconditioner> gradients_;
};

}  // namespace

std::unique_ptr<JointSolver> make_pcg(const GlobalConeProblem& problem, double accuracy) {
  return std::make_unique<ConjugateGradients<JointBlocks>>(
      problem, accuracy, [&](JointBlocks& blocks) { blocks.set_blocks(joint_blocks(problem)); });
}

std::unique_ptr<JointSolver> make_ichol(const GlobalConeProblem& problem, double accuracy) {
  return std::make_unique<ConjugateGradients<Eigen::IncompleteCholesky<double>>>(problem, accuracy, [](auto&) {});
}

}  // namespace lockstep::oracle
