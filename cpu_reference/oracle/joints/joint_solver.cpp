#include "cpu_reference/oracle/joints/joint_solver.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <stdexcept>

namespace lockstep::oracle {

namespace {

constexpr std::array methods = {
    JointMethod{"ldlt", "Baraff's factorisation along the tree of bodies and joints",
                [](const GlobalConeProblem& p, double) { return make_joint_ldlt(p); }},
    JointMethod{"sparse", "CHOLMOD's supernodal Cholesky factorisation, on several cores",
                [](const GlobalConeProblem& p, double) { return make_supernodal(p); }},
    JointMethod{"pcg", "conjugate gradients, preconditioned joint by joint", make_pcg},
    JointMethod{"ichol", "conjugate gradients, preconditioned by an incomplete Cholesky factorisation", make_ichol},
};

bool is_diagonal(const SparseMatrix& m) {
  for (int k = 0; k < m.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator entry(m, k); entry; ++entry) {
      if (entry.row() != entry.col()) return false;
    }
  }
  return true;
}

}  // namespace

SparseMatrix inverse_times(const SparseMatrix& m, const SparseMatrix& a) {
  if (is_diagonal(m)) {
    const Eigen::VectorXd mass = m.diagonal();
    if (mass.size() > 0 && !(mass.minCoeff() > 0)) throw std::runtime_error("M is not positive definite");
    SparseMatrix result = a;  // entry by entry: Eigen's product takes the whole diagonal up for each column
    for (int k = 0; k < result.outerSize(); ++k) {
      for (SparseMatrix::InnerIterator entry(result, k); entry; ++entry) entry.valueRef() /= mass[entry.row()];
    }
    return result;
  }
  const Eigen::SimplicialLLT<SparseMatrix> cholesky(m);
  if (cholesky.info() != Eigen::Success) throw std::runtime_error("M is not positive definite");
  return cholesky.solve(a);
}

SparseMatrix joint_mobility(const GlobalConeProblem& problem) {
  return SparseMatrix(problem.g.transpose()) * inverse_times(problem.m, problem.g);
}

Eigen::VectorXd inverse_roots(const Eigen::VectorXd& mobilities) {
  return (mobilities.array() > 0).select(mobilities.cwiseMax(0).cwiseSqrt().cwiseInverse(), 1);
}

std::span<const JointMethod> joint_methods() { return methods; }

const JointMethod& joint_method(std::string_view name) {
  const auto found = std::ranges::find(methods, name, &JointMethod::name);
  if (found == methods.end()) throw std::invalid_argument("no method for joints is called so");
  return *found;
}

}  // namespace lockstep::oracle
