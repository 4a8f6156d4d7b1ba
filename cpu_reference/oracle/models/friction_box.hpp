// The boxed model without maximum dissipation (M9; survey 4.2.1; Poulsen, Niebe, Erleben 2010, "Heuristic convergence
// rate improvements of the projected Gauss-Seidel method for frictional contact problems"): a normal and two tangents a
// contact, each tangent impulse bounded by itself, |p_t| <= mu p_n. Its matrix J M^-1 J^T is symmetric and positive
// semidefinite with the mobilities on its diagonal, so that matrix splittings can act on it. What it gives up: friction
// is not against the sliding, and across the axes it is sqrt(2) times too strong.
#pragma once

#include "cpu_reference/oracle/lcp/lcp.hpp"
#include "cpu_reference/oracle/models/multibody.hpp"

namespace lockstep::oracle::models {

class FrictionBox {
 public:
  /// The system is kept by reference.
  explicit FrictionBox(const Multibody& system);

  /// Unknowns: normal, first and second tangent of each contact; dry rows of joints; then the joints' rows, which are
  /// free. Splittings solve them in this order.
  lcp::BoxedLcp boxed() const;

  Vector3d impulse(std::size_t contact, const VectorXd& z) const;
  VectorXd velocities(const VectorXd& z) const;
  VectorXd joint_impulses(const VectorXd& z) const { return z.tail(rows_.joint.rows()); }
  VectorXd dry_impulses(const VectorXd& z) const { return z.segment(3 * rows_.normal.rows(), rows_.dry.rows()); }

 private:
  const Multibody& system_;
  Rows rows_;
  MatrixXd all_;  // rows in the order of the unknowns
};

}  // namespace lockstep::oracle::models
