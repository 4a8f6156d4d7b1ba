// Who finds the impulses of joints: x with R x = c, where R = G^T M^-1 G is how mobile their rows are (survey 4.4.1,
// eq 79). c lies in the range of R as far as the rows do not contradict each other.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

class JointSolver {
 public:
  virtual ~JointSolver() = default;
  virtual Eigen::VectorXd solve(const Eigen::VectorXd& c) const = 0;
};

/// R. Throws std::runtime_error where M is not positive definite.
SparseMatrix joint_mobility(const GlobalConeProblem& problem);

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
