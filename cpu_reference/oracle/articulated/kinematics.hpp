// What a configuration and its rates make of each link, from the roots out (the first pass of Featherstone's
// algorithm): V = X V_parent + S rates, A = X A_parent + S rates' + product.
#pragma once

#include "cpu_reference/oracle/articulated/tree.hpp"

namespace lockstep::oracle::articulated {

struct LinkKinematics {
  Columns motion;                           // S: twists about the link's centre of mass
  Vector3d from_parent = Vector3d::Zero();  // from the parent's centre of mass, m
  Vector6 twist = Vector6::Zero();          // V
  Vector6 product = Vector6::Zero();        // of velocities, per second
  Matrix3d inertia = Matrix3d::Zero();      // about the centre of mass, world axes, kg m^2
};

class Kinematics {
 public:
  /// `twists`: of all bodies; those of links are not looked at. All are kept by reference but the rates.
  Kinematics(const Tree& tree, const Configuration& at, const std::vector<Vector6>& twists, const VectorXd& rates);

  const LinkKinematics& link(std::size_t i) const { return links_[i]; }
  Vector6 twist_of(std::size_t body) const;
  const Tree& tree() const { return tree_; }
  const Configuration& configuration() const { return at_; }

  /// What a root has of a parent that moves by itself: X V_parent; zero for free roots and the world.
  Vector6 carried(std::size_t link) const;

  /// diag(m, I) V of a link, and its gyroscopic wrench: (0, w x I w).
  Vector6 momentum(std::size_t link, const Vector6& twist) const;
  Vector6 gyroscopic(std::size_t link) const;

 private:
  const Tree& tree_;
  const Configuration& at_;
  const std::vector<Vector6>& twists_;
  std::vector<LinkKinematics> links_;
};

}  // namespace lockstep::oracle::articulated
