// The direct solve of jointed bodies with closed loops (Baraff 1996, auxiliary constraints; survey 4.4.1):
// a forest of joints in linear time (tree_ldlt.hpp), and what it leaves out, G_a, by its Schur complement
//   S = G_a^T v(G_a),  v(h): the velocities of the forest under impulses h.
#pragma once

#include "cpu_reference/oracle/joints/joint_solver.hpp"
#include "cpu_reference/oracle/joints/tree_ldlt.hpp"

namespace lockstep::oracle {

class JointLdlt final : public JointSolver {
 public:
  /// Throws std::runtime_error where M is not positive definite. S is dense: the rows that close loops are meant to be
  /// few; of redundant ones the least impulses are taken.
  JointLdlt(const SparseMatrix& m, const SparseMatrix& g, const Mechanism& mechanism);

  /// In: h (n) and s (m). Out: v and l with M v = h + G l, G^T v + s = 0, as far as rows do not contradict each other.
  void solve(Eigen::VectorXd& v, Eigen::VectorXd& l) const;

  Eigen::VectorXd solve(const Eigen::VectorXd& c) const override;
  /// Impulses of the rows left out that move nothing, with what the forest answers them.
  Eigen::VectorXd beyond(const Eigen::VectorXd& c) const override;

  const TreeLdlt& tree() const { return tree_; }

 private:
  TreeLdlt tree_;
  SparseMatrix closing_;                // G_a
  Eigen::MatrixXd mobility_, inverse_;  // S and its inverse, or its pseudo-inverse
};

}  // namespace lockstep::oracle
