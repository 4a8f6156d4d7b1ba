// Rows of constraints on the twists of bodies: of contacts, of joints that close loops, of coordinates that something
// acts on. What they answer to each other, J M^-1 J^T with the joints of the trees holding, comes from one pass of the
// articulated-body algorithm a row.
#pragma once

#include <Eigen/Sparse>

#include "cpu_reference/oracle/articulated/articulated_inertia.hpp"

namespace lockstep::oracle::articulated {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// u = on_a . V_a + on_b . V_b; an impulse r of the row acts as the wrenches r on_a and r on_b, each about the centre
/// of mass of its body. `world`: none.
struct Row {
  std::size_t body_a = world, body_b = world;
  Vector6 on_a = Vector6::Zero(), on_b = Vector6::Zero();
};

/// A wrench on b about a point and its opposite on a.
Row row_between(std::size_t body_a, const Pose& a, std::size_t body_b, const Pose& b, const Vector3d& point,
                const Vector6& wrench);

/// A row for each bit of locked_rows(), in order.
std::vector<Row> rows_of(const Joint& joint, const Configuration& at);
/// The row of acting_coordinate().
Row acting_row(const Joint& joint, const Configuration& at);

double velocity(const Row& row, const std::vector<Vector6>& twists);

/// What resists a body that no joint holds.
struct LoneBody {
  double inverse_mass = 0;                      // 1/kg
  Matrix3d inverse_inertia = Matrix3d::Zero();  // 1/(kg m^2), world axes
};

/// Twists that impulses of rows give, the joints of the trees holding. All are kept by reference.
class Mobility {
 public:
  Mobility(const ArticulatedInertia& inertia, const std::vector<LoneBody>& lone) : inertia_(inertia), lone_(lone) {}

  /// M^-1 J^T: column i the twists of all bodies, 6 after another, for a unit impulse of row i.
  SparseMatrix responses(const std::vector<Row>& rows) const;

  /// What a unit impulse of each row gives the row where no joint holds its bodies: the size of its mobility.
  VectorXd unheld(const std::vector<Row>& rows) const;

  /// As answers(), of one wrench on each body, added to `twists`; and to `rates`.
  void push(const std::vector<Vector6>& wrenches, std::vector<Vector6>& twists, VectorXd& rates) const;

 private:
  const ArticulatedInertia& inertia_;
  const std::vector<LoneBody>& lone_;
};

/// J, a row each, of bodies with 6 columns.
SparseMatrix jacobian(const std::vector<Row>& rows, std::size_t bodies);

/// Adds impulses of rows to the wrenches of bodies.
void add_impulses(const std::vector<Row>& rows, const VectorXd& impulses, std::vector<Vector6>& wrenches);

/// R l = -s for a symmetric positive semidefinite R (rows of joints that may say things twice) plus what gives way: of
/// the solutions the one of least norm, rows in units of their mobility without joints (Mobility::unheld). Directions
/// that are 1e-11 times as mobile as that, and less, are held by others already: they get nothing.
class BilateralRows {
 public:
  BilateralRows() = default;
  BilateralRows(const MatrixXd& r, const VectorXd& unheld);
  Index size() const { return scale_.size(); }
  /// -R^+ s, a column each.
  MatrixXd response(const MatrixXd& s) const;

 private:
  VectorXd scale_;
  MatrixXd inverse_;  // of the scaled R
};

}  // namespace lockstep::oracle::articulated
