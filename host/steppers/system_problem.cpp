#include "host/steppers/system_problem.hpp"

#include <Eigen/Geometry>

#include "cpu_reference/oracle/dense.hpp"
#include "host/error.hpp"
#include "host/item_error.hpp"

namespace lockstep {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using oracle::SparseMatrix;

// What a body can do: a column of `linear` and of `angular` for each of its velocities, with the mass that resists it.
struct Freedom {
  u32 first = 0;
  Eigen::Matrix3Xd linear, angular;
  VectorXd mass, velocity;
};

Freedom freedom_of(const SystemBody& body, u32 first) {
  const oracle::SymmetricEigen inertia_modes = oracle::symmetric_eigen<3>(body.inverse_inertia);
  std::vector<int> axes;
  for (int k = 0; k < 3; ++k) {
    if (inertia_modes.values[k] > 1e-12 * inertia_modes.values[2]) axes.push_back(k);
  }
  const int moves = body.inverse_mass > 0 ? 3 : 0, count = moves + int(axes.size());
  Freedom freedom;
  freedom.first = first;
  freedom.linear = freedom.angular = Eigen::Matrix3Xd::Zero(3, count);
  freedom.mass = freedom.velocity = VectorXd::Zero(count);
  for (int k = 0; k < moves; ++k) {
    freedom.linear.col(k) = Vector3d::Unit(k);
    freedom.mass[k] = 1 / body.inverse_mass;
    freedom.velocity[k] = body.v[k];
  }
  for (int k = moves; k < count; ++k) {
    const int axis = axes[std::size_t(k - moves)];
    freedom.angular.col(k) = inertia_modes.vectors.col(axis);
    freedom.mass[k] = 1 / inertia_modes.values[axis];
    freedom.velocity[k] = freedom.angular.col(k).dot(body.w);
  }
  return freedom;
}

// One side of a constraint: what its rows see of a body, linear * v + angular * w.
struct Side {
  u32 body;
  Eigen::MatrixX3d linear, angular;
};

class Assembly {
 public:
  explicit Assembly(const ContactSystem& system) : system_(system) {
    for (const SystemBody& body : system.bodies) {
      freedoms_.push_back(freedom_of(body, velocities_));
      velocities_ += static_cast<u32>(freedoms_.back().mass.size());
    }
    for (const Freedom& freedom : freedoms_) {
      for (Eigen::Index k = 0; k < freedom.mass.size(); ++k)
        mass(freedom.first + k, freedom.first + k, freedom.mass[k]);
    }
    for (const Freedom& freedom : freedoms_) {
      for (const double v : freedom.velocity) v_.push_back(v);
    }
  }

  /// Entries of H or G in columns from `column` on; returns what the rows see of velocities that cannot change.
  VectorXd add(std::vector<Eigen::Triplet<double>>& matrix, Eigen::Index column, const std::vector<Side>& sides) const {
    VectorXd fixed = VectorXd::Zero(sides[0].linear.rows());
    for (const Side& side : sides) {
      const Freedom& freedom = freedoms_[side.body];
      const MatrixXd rows = side.linear * freedom.linear + side.angular * freedom.angular;
      const SystemBody& body = system_.bodies[side.body];
      fixed += side.linear * body.v + side.angular * body.w - rows * freedom.velocity;
      for (Eigen::Index k = 0; k < rows.cols(); ++k) {
        for (Eigen::Index i = 0; i < rows.rows(); ++i)
          matrix.emplace_back(int(freedom.first + k), int(column + i), rows(i, k));
      }
    }
    return fixed;
  }

  /// J M^-1 J^T of the rows alone.
  MatrixXd mobility(const std::vector<Side>& sides) const {
    MatrixXd k = MatrixXd::Zero(sides[0].linear.rows(), sides[0].linear.rows());
    for (const Side& side : sides) {
      const SystemBody& body = system_.bodies[side.body];
      k += body.inverse_mass * side.linear * side.linear.transpose() +
           side.angular * body.inverse_inertia * side.angular.transpose();
    }
    return k;
  }

  void mass(Eigen::Index row, Eigen::Index column, double value) { m_.emplace_back(int(row), int(column), value); }

  /// A further velocity, of no body.
  u32 add_velocity(double v) {
    v_.push_back(v);
    return velocities_++;
  }

  SparseMatrix matrix(const std::vector<Eigen::Triplet<double>>& triplets, Eigen::Index columns) const {
    SparseMatrix result(velocities_, columns);
    result.setFromTriplets(triplets.begin(), triplets.end());
    return result;
  }
  /// The first velocity of each body, and the end of the last.
  std::vector<u32> bodies() const {
    std::vector<u32> first;
    for (const Freedom& freedom : freedoms_) first.push_back(freedom.first);
    first.push_back(freedoms_.empty() ? 0 : freedoms_.back().first + u32(freedoms_.back().mass.size()));
    return first;
  }

  SparseMatrix masses() const { return matrix(m_, velocities_); }
  VectorXd velocities() const { return Eigen::Map<const VectorXd>(v_.data(), Eigen::Index(v_.size())); }

 private:
  const ContactSystem& system_;
  std::vector<Freedom> freedoms_;
  u32 velocities_ = 0;
  std::vector<Eigen::Triplet<double>> m_;
  std::vector<double> v_;
};

// Rows of directions, at the ends of arms: w x arm = -[arm] w.
Side side_at(u32 body, const Eigen::MatrixX3d& directions, const Vector3d& arm, double sign) {
  return {body, sign * directions, -sign * directions * cross_matrix(arm)};
}

struct Joints {
  std::vector<Eigen::Triplet<double>> g;
  std::vector<double> b, l;
  std::vector<u32> first = {0};
  // rows with bounded impulses
  std::vector<Eigen::Triplet<double>> d;
  std::vector<oracle::BoundedLaw> laws;
  std::vector<double> z;
};

bool has_free_row(const SystemJoint& j) {
  const bool bounded = j.slowest > -double(JOINT_UNBOUNDED) || j.fastest < double(JOINT_UNBOUNDED);
  return j.free != FREE_NOTHING && (bounded || j.motor_impulse > 0);
}

// A free row whose velocity is said, as far as it does not give way: as a locked one.
bool free_is_locked(const SystemJoint& j) { return j.motor_impulse == 0 && j.slowest == j.fastest; }

void expect_plain(const SystemJoint& j, const std::string& where) {
  if (has_free_row(j))
    throw ItemError(Failure::input, where, Item::joint, 0, j.joint,
                    "has a motor, friction, limits or a spring, which FCLIB has no rows for; take them away");
}

// A locked row of a joint that some velocity is seen by, and the velocity in m/s that stands for a unit of it.
struct JointRow {
  u32 row;
  double size;
};

double radius_of(const SystemJoint& j, const ContactSystem& system) {
  const SystemBody &a = system.bodies[j.body_a], &b = system.bodies[j.body_b];
  const Matrix3d angular_mobility = a.inverse_inertia + b.inverse_inertia;
  const double angular_mobility_max = oracle::largest_eigenvalue(angular_mobility);
  return angular_mobility_max > 0 ? std::sqrt((a.inverse_mass + b.inverse_mass) / angular_mobility_max) : 0;
}

std::vector<JointRow> rows_of(const SystemJoint& j, const ContactSystem& system) {
  const double radius = radius_of(j, system);
  std::vector<JointRow> rows;
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    if ((j.locked >> i & 1) != 0 && (i < 3 || radius > 0)) rows.push_back({i, i < 3 ? 1 : radius});
  }
  return rows;
}

// The sides of the locked rows of a joint, b against a, angular rows as velocities; and what they carry.
void add_joint(const SystemJoint& j, const ContactSystem& system, Assembly& assembly, Joints& joints) {
  const std::vector<JointRow> rows = rows_of(j, system);
  const auto count = static_cast<Eigen::Index>(rows.size());
  if (count == 0) return;
  Eigen::MatrixX3d linear = Eigen::MatrixX3d::Zero(count, 3), angular = linear;
  VectorXd l(count), bias(count);
  Eigen::Index linear_rows = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto [row, size] = rows[std::size_t(i)];
    linear.row(i) = size * push_of(j, Rows::Unit(row)).transpose();
    angular.row(i) = size * moment_of(j, Rows::Unit(row)).transpose();
    linear_rows += row < 3;
    l[i] = j.impulse[row] / size;
    bias[i] = j.bias[row] * size;
  }
  Side on_a = side_at(j.body_a, linear, j.arm_a, -1), on_b = side_at(j.body_b, linear, j.arm_b, 1);
  on_a.angular -= angular;
  on_b.angular += angular;
  const auto column = static_cast<Eigen::Index>(joints.b.size());
  const VectorXd constant = assembly.add(joints.g, column, {on_a, on_b}) + bias;
  if (j.softness > 0) {
    const MatrixXd compliance = j.softness * assembly.mobility({on_a, on_b});
    const MatrixXd mass = oracle::solve_by_lu(compliance, MatrixXd(MatrixXd::Identity(count, count)));
    const VectorXd slack_velocity = compliance * l;
    for (Eigen::Index i = 0; i < count; ++i) {
      const u32 velocity = assembly.add_velocity(slack_velocity[i]);
      joints.g.emplace_back(int(velocity), int(column + i), 1.0);
      for (Eigen::Index k = 0; k < count; ++k) assembly.mass(velocity, velocity + k - i, mass(i, k));
    }
  }
  joints.b.insert(joints.b.end(), constant.begin(), constant.end());
  joints.l.insert(joints.l.end(), l.begin(), l.end());
  if (linear_rows > 0) joints.first.push_back(static_cast<u32>(column + linear_rows));
  if (linear_rows < count) joints.first.push_back(static_cast<u32>(column + count));
}

// What stands for a unit of the free row's velocity, in m/s; 0 where nothing moves it.
double free_size(const SystemJoint& j, const ContactSystem& system) {
  if (j.effective_mobility <= 0) return 0;
  return j.free == FREE_ANGLE ? radius_of(j, system) : 1;
}

std::vector<Side> free_sides(const SystemJoint& j, double size) {
  const Eigen::MatrixX3d linear = size * free_push_of(j, 1).transpose();
  const Eigen::MatrixX3d angular = size * free_moment_of(j, 1).transpose();
  Side on_a = side_at(j.body_a, linear, j.arm_a, -1), on_b = side_at(j.body_b, linear, j.arm_b, 1);
  on_a.angular -= angular;
  on_b.angular += angular;
  return {on_a, on_b};
}

// u - speed + compliance r = 0 of the free row, all in m/s: what gives way moves against a velocity of its own.
void add_locked_free_row(const std::vector<Side>& sides, double speed, double compliance, double impulse,
                         Assembly& assembly, Joints& joints) {
  const auto column = static_cast<Eigen::Index>(joints.b.size());
  joints.b.push_back(assembly.add(joints.g, column, sides)[0] - speed);
  joints.l.push_back(impulse);
  joints.first.push_back(static_cast<u32>(column + 1));
  if (compliance == 0) return;
  const u32 velocity = assembly.add_velocity(compliance * impulse);
  joints.g.emplace_back(int(velocity), int(column), 1.0);
  assembly.mass(velocity, velocity, 1 / compliance);
}

bool has_impedance_row(const SystemJoint& j, const ContactSystem& system) {
  return j.impedance_compliance > 0 && free_size(j, system) > 0;
}

void add_impedance_row(const SystemJoint& j, const ContactSystem& system, Assembly& assembly, Joints& joints) {
  if (!has_impedance_row(j, system)) return;
  const double size = free_size(j, system);
  add_locked_free_row(free_sides(j, size), size * j.impedance_speed, size * size * j.impedance_compliance,
                      j.impedance_impulse / size, assembly, joints);
}

void add_free_row(const SystemJoint& j, const ContactSystem& system, Assembly& assembly, Joints& joints) {
  const double size = free_size(j, system);
  if (!has_free_row(j) || size == 0) return;
  const std::vector<Side> sides = free_sides(j, size);
  const double bound_compliance = size * size * j.bound_softness * j.effective_mobility,
               spring_compliance = size * size * j.spring_compliance;
  if (free_is_locked(j)) {
    const double compliance = spring_compliance > 0 ? spring_compliance : bound_compliance;
    add_locked_free_row(sides, size * j.slowest, compliance, j.free_impulse / size, assembly, joints);
    return;
  }
  if (j.motor_impulse < 0)
    throw Error(Failure::input, "joint", "has a spring of bounded force, which this solver has no rows for");
  const double fixed = assembly.add(joints.d, static_cast<Eigen::Index>(joints.z.size()), sides)[0];
  joints.laws.push_back({.speed = size * j.motor_speed - fixed,
                         .max_impulse = j.motor_impulse / size,
                         .slowest = size * j.slowest - fixed,
                         .fastest = size * j.fastest - fixed,
                         .bound_compliance = bound_compliance,
                         .spring_compliance = spring_compliance,
                         .mobility = size * size * j.effective_mobility});
  joints.z.push_back(j.free_impulse / size);
}

// Rows: the normal and two tangents.
Matrix3d frame_of(const SystemContact& c) {
  Matrix3d frame;
  frame.row(0) = c.normal.transpose();
  frame.row(1) = c.normal.unitOrthogonal().transpose();
  frame.row(2) = c.normal.cross(c.normal.unitOrthogonal()).transpose();
  return frame;
}

void push(SystemBody& body, const Vector3d& arm, const Vector3d& impulse, const Vector3d& moment) {
  body.v += body.inverse_mass * impulse;
  body.w += body.inverse_inertia * (arm.cross(impulse) + moment);
}

}  // namespace

WholeSystemProblem whole_problem_of(const ContactSystem& system) {
  Assembly assembly(system);
  const auto n = static_cast<Eigen::Index>(system.contacts.size());
  WholeSystemProblem result;
  oracle::GlobalConeProblem& problem = result.problem.cones;
  problem.w = VectorXd::Zero(3 * n);
  problem.mu = VectorXd::Zero(n);
  result.impulses.r = VectorXd::Zero(3 * n);
  std::vector<Eigen::Triplet<double>> h;
  for (Eigen::Index i = 0; i < n; ++i) {
    const SystemContact& c = system.contacts[std::size_t(i)];
    const Matrix3d frame = frame_of(c);
    problem.w.segment<3>(3 * i) =
        assembly.add(h, 3 * i, {side_at(c.body_a, frame, c.arm_a, 1), side_at(c.body_b, frame, c.arm_b, -1)});
    problem.w.segment<3>(3 * i) += frame * (c.bias * c.normal + c.slide);
    problem.mu[i] = c.friction;
    result.impulses.r.segment<3>(3 * i) = frame * c.impulse;
  }
  Joints joints;
  for (u32 i = 0; i < system.joints.size(); ++i) {
    const SystemJoint& j = system.joints[i];
    add_joint(j, system, assembly, joints);
    for (const auto& [row, size] : rows_of(j, system)) result.locked.push_back({i, row, size});
    add_impedance_row(j, system, assembly, joints);
    if (has_impedance_row(j, system))
      result.locked.push_back({i, WholeSystemProblem::IMPEDANCE_ROW, free_size(j, system)});
    add_free_row(j, system, assembly, joints);
    const WholeSystemProblem::Row free = {i, JOINT_ROWS, free_size(j, system)};
    if (has_free_row(j) && free.size > 0) (free_is_locked(j) ? result.locked : result.bounded).push_back(free);
  }
  const auto rows = static_cast<Eigen::Index>(joints.b.size());
  problem.m = assembly.masses();
  problem.h = assembly.matrix(h, 3 * n);
  problem.g = assembly.matrix(joints.g, rows);
  problem.b = Eigen::Map<const VectorXd>(joints.b.data(), rows);
  result.impulses.l = Eigen::Map<const VectorXd>(joints.l.data(), rows);
  if (rows > 0) problem.first = joints.first;
  problem.bodies = assembly.bodies();
  const auto bounded = static_cast<Eigen::Index>(joints.z.size());
  result.problem.d = assembly.matrix(joints.d, bounded);
  result.problem.laws = std::move(joints.laws);
  result.impulses.z = Eigen::Map<const VectorXd>(joints.z.data(), bounded);
  // velocities without the impulses of the step
  problem.f = problem.m * assembly.velocities() - problem.h * result.impulses.r - problem.g * result.impulses.l -
              result.problem.d * result.impulses.z;
  return result;
}

SystemProblem problem_of(const ContactSystem& system, const std::string& where) {
  for (const SystemJoint& j : system.joints) expect_plain(j, where);
  WholeSystemProblem whole = whole_problem_of(system);
  return {std::move(whole.problem.cones), {std::move(whole.impulses.r), std::move(whole.impulses.l)}};
}

SystemImpulses impulses_of(const ContactSystem& system, const oracle::MixedImpulses& impulses) {
  SystemImpulses result;
  for (const SystemContact& c : system.contacts)
    result.contacts.push_back(frame_of(c).transpose() *
                              impulses.r.segment<3>(3 * static_cast<Eigen::Index>(result.contacts.size())));
  Eigen::Index next = 0, next_bounded = 0;
  for (const SystemJoint& j : system.joints) {
    Rows& rows = result.joints.emplace_back(Rows::Zero());
    for (const auto& [row, size] : rows_of(j, system)) rows[row] = size * impulses.l[next++];
    const double size = free_size(j, system);
    double& impedance = result.impedances.emplace_back(0);
    if (has_impedance_row(j, system)) impedance = size * impulses.l[next++];
    double& free = result.free.emplace_back(0);
    if (has_free_row(j) && size > 0)
      free = size * (free_is_locked(j) ? impulses.l[next++] : impulses.z[next_bounded++]);
  }
  return result;
}

SystemImpulses impulses_of(const ContactSystem& system, const oracle::ConeImpulses& impulses) {
  return impulses_of(system, oracle::MixedImpulses{impulses.r, impulses.l, {}});
}

void set_impulses(ContactSystem& system, const SystemImpulses& impulses) {
  for (std::size_t i = 0; i < system.contacts.size(); ++i) {
    SystemContact& c = system.contacts[i];
    const Vector3d change = impulses.contacts[i] - c.impulse;
    push(system.bodies[c.body_a], c.arm_a, change, Vector3d::Zero());
    push(system.bodies[c.body_b], c.arm_b, -change, Vector3d::Zero());
    c.impulse = impulses.contacts[i];
  }
  for (std::size_t i = 0; i < system.joints.size(); ++i) {
    SystemJoint& j = system.joints[i];
    const Rows change = impulses.joints[i] - j.impulse;
    const double free_change = impulses.free.empty() ? 0 : impulses.free[i] - j.free_impulse;
    const double impedance_change = impulses.impedances.empty() ? 0 : impulses.impedances[i] - j.impedance_impulse;
    const double whole_change = free_change + impedance_change;
    const Vector3d impulse = push_of(j, change) + free_push_of(j, whole_change);
    const Vector3d moment = moment_of(j, change) + free_moment_of(j, whole_change);
    push(system.bodies[j.body_a], j.arm_a, -impulse, -moment);
    push(system.bodies[j.body_b], j.arm_b, impulse, moment);
    j.impulse = impulses.joints[i];
    j.free_impulse += free_change;
    j.impedance_impulse += impedance_change;
  }
}

}  // namespace lockstep
