// Who finds the impulses of joints: x with R x = c, where R = G^T M^-1 G is how mobile their rows are (survey 4.4.1,
// eq 79). c lies in the range of R as far as the rows do not contradict each other. Where it does not, R x is what is
// nearest to it, and x gets nothing of what no impulses do.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

/// Of the largest eigenvalue: below it rows say nothing new. What joints answer is good to some 1e-14 of it.
inline constexpr double redundant_rows = 1e-11;

class JointSolver {
 public:
  virtual ~JointSolver() = default;
  virtual Eigen::VectorXd solve(const Eigen::VectorXd& c) const = 0;
  /// A y with R y = 0 and y . c not 0, where c is not in the range of R (contradiction.hpp); elsewhere nothing but
  /// rounding.
  virtual Eigen::VectorXd beyond(const Eigen::VectorXd& c) const = 0;
};

/// R. Throws std::runtime_error where M is not positive definite.
SparseMatrix joint_mobility(const GlobalConeProblem& problem);

/// 1 / sqrt of mobilities, which makes of R a matrix with a diagonal of 1; 1 of rows that nothing moves.
Eigen::VectorXd inverse_roots(const Eigen::VectorXd& mobilities);

/// M^-1 A, sparse. Throws std::runtime_error where M is not positive definite.
SparseMatrix inverse_times(const SparseMatrix& m, const SparseMatrix& a);

struct JointMethod {
  std::string_view name, description;
  /// Of a problem with joints. `accuracy`: |c - R x| / |c| at which one that iterates may end. Throws
  /// std::runtime_error where M is not positive definite.
  std::unique_ptr<JointSolver> (*make)(const GlobalConeProblem& problem, double accuracy);
};

/// `ldlt`, `sparse`, `pcg` and `ichol`.
std::span<const JointMethod> joint_methods();
const JointMethod& joint_method(std::string_view name);

// a file each
std::unique_ptr<JointSolver> make_joint_ldlt(const GlobalConeProblem& problem);
std::unique_ptr<JointSolver> make_supernodal(const GlobalConeProblem& problem);
std::unique_ptr<JointSolver> make_pcg(const GlobalConeProblem& problem, double accuracy);
std::unique_ptr<JointSolver> make_ichol(const GlobalConeProblem& problem, double accuracy);

}  // namespace lockstep::oracle
