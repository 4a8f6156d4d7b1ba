// The problem of one contact: given its block W (3 x 3) and the velocity q that it would have without its own impulse,
// find r in K with u = W r + q, u^ = u + mu |u_t| n in the dual cone, r . u^ = 0. Three ways to solve it.
#pragma once

#include <Eigen/Core>

namespace lockstep::oracle {

/// What does not change from solve to solve. With the normal row eliminated, r_n = -(q_n + h . r_t) / w_nn, where
/// h = W_tn; A = W_tt - h h^T / w_nn in its eigenframe.
class LocalCone {
 public:
  LocalCone(const Eigen::Matrix3d& w, double mu);

  /// Exactly, by cases: open, stick, or slip, whose multiplier is the root of one function.
  Eigen::Vector3d solve(const Eigen::Vector3d& q) const;

  /// All candidates, of which the one with the least defect is taken: open, stick, and every root of the quartic.
  Eigen::Vector3d enumerate(const Eigen::Vector3d& q) const;

  /// By splitting: from r, r <- P_K(r - rho u^) until it settles.
  Eigen::Vector3d split(const Eigen::Vector3d& q, Eigen::Vector3d r) const;

 private:
  struct Slip;  // the problem with the normal row eliminated
  Slip eliminate(const Eigen::Vector3d& q) const;
  Eigen::Vector3d impulse(const Slip& slip, double lambda) const;
  Eigen::Vector3d stick(const Slip& slip) const;
  double defect(const Eigen::Vector3d& q, const Eigen::Vector3d& r) const;

  Eigen::Matrix3d w_;
  double mu_, mobility_;   // mobility: lambda_max(W)
  Eigen::Vector2d a_;      // eigenvalues of A, rising
  Eigen::Matrix2d frame_;  // its eigenvectors
  Eigen::Vector2d h_;      // in them
};

}  // namespace lockstep::oracle
