// One step's constraints in double, as the models of the survey take them (sections 3.4 - 3.6): bodies that moved
// freely, contacts, and rows of joints. World frame, SI units.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace lockstep::oracle::models {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Body {
  double inverse_mass = 0;                                    // 1/kg; 0: immovable
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();  // 1/(kg m^2)
  Vector3d v = Vector3d::Zero(), w = Vector3d::Zero();  // what they would be at the step's end without constraints
};

/// Impulses act on a, and their opposites on b.
struct Contact {
  std::size_t body_a = 0, body_b = 0;
  Vector3d normal = Vector3d::UnitZ();                          // from b to a, unit
  Vector3d arm_a = Vector3d::Zero(), arm_b = Vector3d::Zero();  // from the centre of mass to the point, m
  double bias = 0;                                              // m/s: u_n + bias >= 0, C / dt + dC/dt of eq 49
  double friction = 0;                                          // mu
  Vector3d slide = Vector3d::Zero();  // m/s, added to u in the tangent plane: of a law of impact
};

/// u = linear . (v_a - v_b) + angular_a . w_a + angular_b . w_b
struct Row {
  std::size_t body_a = 0, body_b = 0;
  Vector3d linear = Vector3d::Zero(), angular_a = Vector3d::Zero(), angular_b = Vector3d::Zero();
};

/// u + bias = 0 (eq 48).
struct BilateralRow {
  Row row;
  double bias = 0;
};

/// Dry friction of a joint's free direction: |impulse| <= limit, against u (eq 54).
struct DryRow {
  Row row;
  double limit = 0;  // dt times the largest force or moment
};

struct Multibody {
  std::vector<Body> bodies;
  std::vector<Contact> contacts;
  std::vector<BilateralRow> joint_rows;
  std::vector<DryRow> dry_rows;
};

/// Rows of Jacobians and what inertia makes of them: columns are v and w of each body, 6 after another.
class Rows {
 public:
  explicit Rows(const Multibody& system);

  MatrixXd normal, tangent;  // of the contacts: one row each; two rows each, along the tangents
  MatrixXd joint, dry;       // of the joints' rows

  /// M^-1 J^T, and the free velocities, of all bodies.
  MatrixXd inertia_times(const MatrixXd& jacobian) const;
  VectorXd free_velocity;

 private:
  const Multibody& system_;
};

/// Two unit vectors that make a right-handed frame with a unit normal: of the axes x, y, z the one that is least along
/// the normal gives the first. For the normal z they are x and y.
Eigen::Matrix<double, 3, 2> tangents(const Vector3d& normal);

/// The joints' rows J_b eliminated: A = W - W_b G^-1 W_b^T and their impulses, with G = J_b M^-1 J_b^T. This is what
/// Model-LCP's F - B D^-1 C comes to (docs/theory/lcp.md). Throws Error where G has not full rank: a closed loop, or a
/// row that says nothing new.
class JointElimination {
 public:
  JointElimination(const Rows& rows, const Multibody& system);

  /// J M^-1 J^T, and J u, of rows J while the joints hold.
  MatrixXd delassus(const MatrixXd& jacobian) const;
  VectorXd free_velocity(const MatrixXd& jacobian) const;

  /// The velocities of all bodies after these impulses of rows J, and what the joints' rows answer, N s and N m s.
  VectorXd velocities(const MatrixXd& jacobian, const VectorXd& impulses) const;
  VectorXd joint_impulses(const MatrixXd& jacobian, const VectorXd& impulses) const;

 private:
  MatrixXd joints_response(const MatrixXd& joint_velocities) const;  // G^-1 x

  const Rows& rows_;
  MatrixXd inverse_mass_joints_;  // M^-1 J_b^T
  MatrixXd inverse_;              // G^-1, scaled to a unit diagonal of G
  VectorXd scale_;
  VectorXd alone_;     // impulses of the joints, they alone acting
  VectorXd velocity_;  // of all bodies then
};

}  // namespace lockstep::oracle::models
