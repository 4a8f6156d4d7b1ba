// Model-mLCP and Model-LCP (survey 3.5, 3.6, definitions 7 and 8): Coulomb's cone as a pyramid of n_d sides. At each
// contact n_d unit vectors d_j positively span the tangent plane, and
//   0 <= J_n u + bias          _|_  p_n    >= 0        (49)
//   0 <= D^T J_f u + e beta    _|_  alpha  >= 0        (53), friction = D alpha
//   0 <= mu p_n - e^T alpha    _|_  beta   >= 0,
// and the same for dry friction in a joint's free direction with D = [1 -1] and p_max for mu p_n (54). The order of the
// unknowns is the survey's: x = (p_n, alpha of joints, alpha of contacts, beta of joints, beta of contacts).
#pragma once

#include "cpu_reference/oracle/lcp/lcp.hpp"
#include "cpu_reference/oracle/models/multibody.hpp"

namespace lockstep::oracle::models {

/// 0 <= F x + B w + a  _|_  x >= 0,   C x + D w + r = 0 (26, 27).
struct MixedLcp {
  MatrixXd f, b, c, d;
  VectorXd a, r;

  /// The same with x and w in one vector: rows of w are free.
  lcp::BoxedLcp stacked() const;
};

/// cos(2 pi j / n_d), sin(2 pi j / n_d), a column each. Throws Error for fewer than 3.
Eigen::Matrix2Xd pyramid_directions(int directions);

/// What couples the unknowns of a pyramid without any motion, F of (26): e beta in the rows of alpha, mu p_n - e^T
/// alpha in those of beta; `friction`: mu of each contact. Of `size` unknowns those behind the survey's are coupled
/// with none.
MatrixXd pyramid_couplings(const VectorXd& friction, Index dry, Index directions, Index size);

class FrictionPyramid {
 public:
  /// Directions are cos(2 pi j / n_d) t_1 + sin(2 pi j / n_d) t_2 with the tangents of the contact. Throws Error for
  /// fewer than 3 directions. The system is kept by reference.
  FrictionPyramid(const Multibody& system, int directions);

  /// w = (velocities of the bodies that move, impulses of the joints' rows); D = [-M J^T; J 0]. A body that moves but
  /// does not turn has three velocities. Throws Error for an inertia that is neither zero nor regular.
  MixedLcp mixed() const;

  /// Joints eliminated. Throws Error where they are not independent (JointElimination).
  lcp::Lcp reduced() const;

  /// The impulse on body a of a contact, from x.
  Vector3d impulse(std::size_t contact, const VectorXd& x) const;

  /// The velocities of all bodies, 6 after another, from an x of `reduced`.
  VectorXd velocities(const VectorXd& x) const;

  /// What the joints' rows carry then, N s and N m s.
  VectorXd joint_impulses(const VectorXd& x) const;

  /// What dry friction in joints does, N s and N m s.
  VectorXd dry_impulses(const VectorXd& x) const;

  Index size() const { return normals_ + 2 * dry_ + normals_ * directions_ + dry_ + normals_; }

 private:
  MatrixXd impulse_rows() const;  // of p_n, alpha of joints, alpha of contacts
  MatrixXd couplings() const;     // F
  VectorXd constants() const;     // of a, without velocities

  const Multibody& system_;
  Rows rows_;
  Index directions_, normals_, dry_;
  Eigen::Matrix2Xd circle_;  // the directions, in the tangent plane
};

}  // namespace lockstep::oracle::models
