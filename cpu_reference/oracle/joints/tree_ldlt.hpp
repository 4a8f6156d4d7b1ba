// Baraff's direct solve of jointed bodies in linear time (Linear-time dynamics using Lagrange multipliers, SIGGRAPH
// 1996; survey 4.4.1). The velocities v of bodies under impulses h, and the impulses l of joints that keep them:
//   [ M    -G ] [ v ]   [ h ]
//   [ -G^T  0 ] [ l ] = [ s ]          M v = h + G l,   G^T v + s = 0
// Bodies and joints are the nodes of a forest, which is factorised from the leaves to the roots:
//   D_n = K_nn - sum over children c of L_c D_c L_c^T,   L_n = K_pn D_n^-1 with p the parent of n
// A node has one parent, so that nothing is filled in: time and memory are proportional to the number of nodes.
// D of a body is M and what hangs on it, the inertia of Featherstone's articulated body; -D of a joint is how mobile
// the bodies are that hang on it. So that something does hang on each joint, one that holds a body to the world is the
// root of its tree.
//
// Joints that would close a loop are left out, two to the world among them; and those whose rows are dependent as far
// as what hangs on them can tell, for their D has no inverse: joint_ldlt.hpp adds them.
#pragma once

#include "cpu_reference/oracle/joints/mechanism.hpp"

namespace lockstep::oracle {

class TreeLdlt {
 public:
  /// M: n x n, symmetric and positive definite; G: n x m. Throws std::runtime_error where M is not positive definite.
  TreeLdlt(const SparseMatrix& m, const SparseMatrix& g, const Mechanism& mechanism);

  /// In: h (n) and s (m). Out: v and l, which is 0 in the rows that were left out.
  void solve(Eigen::VectorXd& v, Eigen::VectorXd& l) const;

  /// Rows of joints that were left out, rising.
  const std::vector<Eigen::Index>& left_out() const { return left_out_; }

  Eigen::Index velocities() const { return static_cast<Eigen::Index>(slot_of_velocity_.size()); }

  /// Numbers that the factors hold.
  std::size_t stored() const { return data_.size(); }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t(0);
  struct Node {
    bool is_joint;
    std::uint32_t index;                // of the body or of the joint
    std::uint32_t parent = none;        // slot in nodes_
    Eigen::Index first = 0, size = 0;   // of its part of the vectors
    std::size_t factor = 0, lower = 0;  // slots in data_ of the Cholesky factor of +-D, and of L
    bool left_out = false;
  };

  void order(const Mechanism& mechanism);
  void assemble(const SparseMatrix& m, const SparseMatrix& g);
  void factorise();
  void eliminate(Node& node);

  std::vector<Node> nodes_;                                   // children before their parents
  std::vector<Eigen::Index> slot_of_velocity_, slot_of_row_;  // in the vectors; -1 of a row that is left out
  std::vector<double> data_;
  std::vector<Eigen::Index> left_out_;
  Eigen::Index size_ = 0;
};

}  // namespace lockstep::oracle
