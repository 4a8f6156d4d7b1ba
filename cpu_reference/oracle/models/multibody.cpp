#include "cpu_reference/oracle/models/multibody.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "cpu_reference/oracle/dense.hpp"
#include "host/error.hpp"

namespace lockstep::oracle::models {

namespace {

constexpr double full_rank = 1e-10;  // smallest pivot of a G scaled to a unit diagonal, to its largest

void set_row(MatrixXd& jacobian, Index row, const Row& r) {
  const Index a = 6 * Index(r.body_a), b = 6 * Index(r.body_b);
  jacobian.row(row).segment<3>(a) += r.linear.transpose();
  jacobian.row(row).segment<3>(a + 3) += r.angular_a.transpose();
  jacobian.row(row).segment<3>(b) -= r.linear.transpose();
  jacobian.row(row).segment<3>(b + 3) += r.angular_b.transpose();
}

// direction . (v_a + w_a x arm_a - v_b - w_b x arm_b)
Row contact_row(const Contact& c, const Vector3d& direction) {
  return {c.body_a, c.body_b, direction, c.arm_a.cross(direction), -c.arm_b.cross(direction)};
}

}  // namespace

Eigen::Matrix<double, 3, 2> tangents(const Vector3d& normal) {
  int axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  const Vector3d along = Vector3d::Unit(axis);
  Eigen::Matrix<double, 3, 2> t;
  t.col(0) = (along - along.dot(normal) * normal).normalized();
  t.col(1) = normal.cross(t.col(0));
  return t;
}

Rows::Rows(const Multibody& system) : system_(system) {
  const Index columns = 6 * Index(system.bodies.size()), contacts = Index(system.contacts.size());
  normal = MatrixXd::Zero(contacts, columns);
  tangent = MatrixXd::Zero(2 * contacts, columns);
  joint = MatrixXd::Zero(Index(system.joint_rows.size()), columns);
  dry = MatrixXd::Zero(Index(system.dry_rows.size()), columns);
  free_velocity.resize(columns);
  for (Index i = 0; i < contacts; ++i) {
    const Contact& c = system.contacts[std::size_t(i)];
    const Eigen::Matrix<double, 3, 2> t = tangents(c.normal);
    set_row(normal, i, contact_row(c, c.normal));
    set_row(tangent, 2 * i, contact_row(c, t.col(0)));
    set_row(tangent, 2 * i + 1, contact_row(c, t.col(1)));
  }
  for (Index i = 0; i < joint.rows(); ++i) set_row(joint, i, system.joint_rows[std::size_t(i)].row);
  for (Index i = 0; i < dry.rows(); ++i) set_row(dry, i, system.dry_rows[std::size_t(i)].row);
  for (std::size_t b = 0; b < system.bodies.size(); ++b)
    free_velocity.segment<6>(6 * Index(b)) << system.bodies[b].v, system.bodies[b].w;
}

MatrixXd Rows::inertia_times(const MatrixXd& jacobian) const {
  MatrixXd result = jacobian.transpose();
  if (result.size() == 0) return result;  // no memory to take blocks of
  for (std::size_t b = 0; b < system_.bodies.size(); ++b) {
    const Index row = 6 * Index(b);
    result.middleRows(row, 3) *= system_.bodies[b].inverse_mass;
    result.middleRows(row + 3, 3) = (system_.bodies[b].inverse_inertia * result.middleRows(row + 3, 3)).eval();
  }
  return result;
}

JointElimination::JointElimination(const Rows& rows, const Multibody& system) : rows_(rows) {
  const Index n = rows.joint.rows();
  velocity_ = rows.free_velocity;
  inverse_mass_joints_ = rows.inertia_times(rows.joint);
  if (n == 0) return;
  const MatrixXd g = product(rows.joint, inverse_mass_joints_);
  scale_ = VectorXd::Ones(n);
  for (Index i = 0; i < n; ++i) {
    if (g(i, i) > 0) scale_[i] = 1 / std::sqrt(g(i, i));
  }
  const auto [rank, inverse] = rank_and_inverse(scale_.asDiagonal() * g * scale_.asDiagonal(), full_rank);
  if (rank < n) {
    throw Error(
        Failure::input, "joints",
        "their " + std::to_string(n) + " rows have rank " + std::to_string(rank) +
            ": a closed loop, or rows that say the same; Model-LCP needs independent rows, Model-mLCP does not");
  }
  inverse_ = inverse;
  VectorXd u = rows.joint * rows.free_velocity;
  for (Index i = 0; i < n; ++i) u[i] += system.joint_rows[std::size_t(i)].bias;
  alone_ = -joints_response(u);
  velocity_ += inverse_mass_joints_ * alone_;
}

MatrixXd JointElimination::joints_response(const MatrixXd& u) const {
  return scale_.asDiagonal() * product(inverse_, scale_.asDiagonal() * u);
}

MatrixXd JointElimination::delassus(const MatrixXd& jacobian) const {
  const MatrixXd mobility = rows_.inertia_times(jacobian), coupling = product(rows_.joint, mobility);
  const MatrixXd w = product(jacobian, mobility) - transposed_product(coupling, joints_response(coupling));
  return 0.5 * (w + w.transpose());
}

VectorXd JointElimination::free_velocity(const MatrixXd& jacobian) const { return jacobian * velocity_; }

VectorXd JointElimination::velocities(const MatrixXd& jacobian, const VectorXd& impulses) const {
  const VectorXd change = rows_.inertia_times(jacobian) * impulses;
  return velocity_ + change - inverse_mass_joints_ * joints_response(rows_.joint * change);
}

VectorXd JointElimination::joint_impulses(const MatrixXd& jacobian, const VectorXd& impulses) const {
  if (rows_.joint.rows() == 0) return {};
  return alone_ - joints_response(rows_.joint * (rows_.inertia_times(jacobian) * impulses));
}

}  // namespace lockstep::oracle::models
