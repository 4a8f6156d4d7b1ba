// Featherstone's articulated-body algorithm (Featherstone 1983; Rigid Body Dynamics Algorithms, 2008, 7.3): for a tree
// of links with A = X A_parent + S a + c it finds, in O(n), the joint rates' changes a and the twists' changes A that
// wrenches F on the links and efforts t at the joints make,
//   M_i A_i = F_i + (what the joints of i carry),   S_i^T (what the joint of i carries) = t_i
// which is Gauss' principle: they make  sum of A^T M A / 2 - A^T F - a^T t  least. From the leaves to the roots
//   I_A = M + sum over children of X^T (I_A - U D^-1 U^T) X,   U = I_A S,   D = S^T U
//   p = -F + sum over children of X^T (p + I_a c + U D^-1 u),  u = t - S^T p,  I_a = I_A - U D^-1 U^T
// and out again  A' = X A_parent + c,  a = D^-1 (u - U^T A'),  A = A' + S a;  the joint carries I_A A + p.
// Forces give accelerations, impulses changes of velocity: the units are the caller's.
#pragma once

#include "cpu_reference/oracle/articulated/kinematics.hpp"

namespace lockstep::oracle::articulated {

/// Of each link, in the order of the tree.
using LinkVectors = std::vector<Vector6>;

struct TreeResponse {
  VectorXd rates;       // a, of all links
  LinkVectors twist;    // A
  LinkVectors carried;  // what the joint to the parent does to the link, about its centre of mass
};

class ArticulatedInertia {
 public:
  /// The pass from the leaves to the roots. The kinematics are kept by reference.
  explicit ArticulatedInertia(const Kinematics& at);

  /// `wrench`: F; `effort`: t (empty: zero); `product`: c (empty: zero). Of one tree if `only` says so; the others'
  /// answers are zero then.
  TreeResponse solve(const LinkVectors& wrench, const VectorXd& effort = {}, const LinkVectors& product = {}) const;
  void solve_tree(std::size_t tree, const LinkVectors& wrench, const VectorXd& effort, const LinkVectors& product,
                  TreeResponse& response) const;

  const Kinematics& at() const { return at_; }

 private:
  struct Factor {
    Matrix6 inertia;                                                         // I_A
    Columns response;                                                        // U
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> inverse;  // D^-1
  };
  const Kinematics& at_;
  std::vector<Factor> factors_;
};

/// The rates of the joints that these twists of all bodies have once the joints grip: the momentum across what they
/// lock is theirs. Twists that obey the joints keep their rates.
VectorXd gripped_rates(const ArticulatedInertia& inertia, const std::vector<Vector6>& twists);

}  // namespace lockstep::oracle::articulated
