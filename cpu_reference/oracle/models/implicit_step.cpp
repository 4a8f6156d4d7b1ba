#include "cpu_reference/oracle/models/implicit_step.hpp"

#include <algorithm>
#include <chrono>
#include <unsupported/Eigen/AutoDiff>

#include "cpu_reference/oracle/dense.hpp"
#include "cpu_reference/oracle/models/implicit_equations.hpp"

namespace lockstep::oracle::models {

namespace {

using Number = Eigen::AutoDiffScalar<VectorXd>;  // with its derivatives by all unknowns
using Numbers = Eigen::Matrix<Number, Eigen::Dynamic, 1>;

Eigen::Matrix3d inverse_inertia(const ImplicitBody& body) {
  if (!(body.mass > 0)) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d r = body.q.toRotationMatrix();
  return r * body.inertia.inverse() * r.transpose();
}

double inverse_mass(const ImplicitBody& body) { return body.mass > 0 ? 1 / body.mass : 0; }

BodyAt<double> start_of(const ImplicitBody& body) {
  return body_at<double>(body, Vector3d::Zero(), Vector3d::Zero(), 0);
}

RowSizes row_sizes(const ImplicitSystem& system) {
  RowSizes sizes;
  for (const SurfaceContact& c : system.contacts) {
    const ImplicitBody &a = system.bodies[c.body_a], &b = system.bodies[c.body_b];
    const ContactAt<double> any = contact_at<double>(c, start_of(a), start_of(b), Vector3d(0.6, 0.7, 0.4));
    sizes.across.push_back(tangents(any.normal).col(0));
    const Vector3d moment_a = any.arm_a.cross(any.normal), moment_b = any.arm_b.cross(any.normal);
    sizes.mobility.push_back(inverse_mass(a) + inverse_mass(b) + moment_a.dot(inverse_inertia(a) * moment_a) +
                             moment_b.dot(inverse_inertia(b) * moment_b));
  }
  for (const ImplicitJoint& j : system.joints) {
    const ImplicitBody &a = system.bodies[j.body_a], &b = system.bodies[j.body_b];
    const Eigen::Matrix3d angular_mobility = inverse_inertia(a) + inverse_inertia(b);
    const double largest = largest_eigenvalue(angular_mobility);
    sizes.radius.push_back(std::sqrt((inverse_mass(a) + inverse_mass(b)) / largest));
    const Vector3d axis = a.q * j.axis_a;
    sizes.mobility.push_back(axis.dot(angular_mobility * axis));
  }
  return sizes;
}

// The largest speed that bodies have without impulses.
double free_speed(const ImplicitSystem& system) {
  double largest = 0;
  for (const ImplicitBody& b : system.bodies) {
    if (!(b.mass > 0)) continue;
    largest = std::max({largest, b.v.norm(), system.dt * b.force.norm() / b.mass,
                        b.w.norm() * std::sqrt(b.inertia.diagonal().maxCoeff() / b.mass)});
  }
  return largest;
}

class Solver {
 public:
  Solver(const ImplicitSystem& system, const SolveLimits& limits, VectorXd& y)
      : system_(system), limits_(limits), sizes_(row_sizes(system)), y_(y), speed_(free_speed(system)) {
    if (y.size() == unknowns(system)) return;
    y = VectorXd::Zero(unknowns(system));
    Index next = 0;
    for (const ImplicitBody& b : system.bodies) {
      if (!(b.mass > 0)) continue;
      y.segment<6>(next) << b.v + system.dt / b.mass * b.force, b.w;
      next += 6;
    }
  }

  double residual(const VectorXd& y, const VectorXd* frozen) const {
    const VectorXd f = Equations<double>(system_, sizes_, y, frozen).left_side();
    const double largest = f.size() > 0 ? f.cwiseAbs().maxCoeff() : 0;
    return speed_ > 0 ? largest / speed_ : largest;
  }

  // Newton's method; `frozen` as in Equations. True where the tolerance was reached, in `x` the best.
  bool newton(VectorXd& x, const VectorXd* frozen, double tolerance, SolveReport* report) {
    VectorXd best = x;
    double least = residual(x, frozen);
    for (std::uint32_t iteration = 0;; ++iteration) {
      const double current = residual(x, frozen);
      if (current < least) {
        least = current;
        best = x;
      }
      if (report) {
        report->iterations = iteration;
        report->residuals.push_back(current);
      }
      if (current <= tolerance || iteration >= most_steps(report) || seconds() > limits_.seconds) break;
      if (!step(x, frozen)) break;
    }
    x = best;
    return least <= tolerance;
  }

  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  SolveReport finish(SolveReport report, const VectorXd* frozen) {
    report.residual = residual(y_, frozen);
    report.seconds = seconds();
    const bool out_of_limits = report.iterations >= limits_.iterations || report.seconds > limits_.seconds;
    report.stop = report.residual <= limits_.tolerance ? Stop::solved : out_of_limits ? Stop::limit : Stop::stalled;
    return report;
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::uint32_t most_steps(const SolveReport* report) const { return report ? limits_.iterations : 100; }

  // False where no step length lowers the sum of squares.
  bool step(VectorXd& x, const VectorXd* frozen) const {
    const Index n = x.size();
    Numbers numbers(n);
    for (Index i = 0; i < n; ++i) numbers[i] = Number(x[i], n, i);
    const Numbers f = Equations<Number>(system_, sizes_, numbers, frozen).left_side();
    VectorXd values(n);
    MatrixXd jacobian = MatrixXd::Zero(n, n);
    for (Index i = 0; i < n; ++i) {
      values[i] = f[i].value();
      if (f[i].derivatives().size() == n) jacobian.row(i) = f[i].derivatives().transpose();
    }
    // of what is redundant, the least change
    const VectorXd d = -solve_by_least_norm(jacobian, values);
    const double merit = values.norm();
    for (double length = 1; length > 1e-4; length *= 0.5) {
      const VectorXd next = x + length * d;
      if (Equations<double>(system_, sizes_, next, frozen).left_side().norm() >= (1 - 1e-4 * length) * merit) continue;
      x = next;
      return true;
    }
    return false;
  }

  const ImplicitSystem& system_;
  const SolveLimits limits_;
  const RowSizes sizes_;
  VectorXd& y_;
  const double speed_;
  const Clock::time_point start_ = Clock::now();
};

}  // namespace

Index unknowns(const ImplicitSystem& system) {
  Index count = 3 * Index(system.contacts.size());
  for (const ImplicitBody& b : system.bodies) count += b.mass > 0 ? 6 : 0;
  for (const ImplicitJoint& j : system.joints) count += j.hinge ? 6 : 3;
  return count;
}

SolveReport implicit_newton(const ImplicitSystem& system, const SolveLimits& limits, VectorXd& y) {
  Solver solver(system, limits, y);
  SolveReport report;
  solver.newton(y, nullptr, limits.tolerance, &report);
  return solver.finish(report, nullptr);
}

SolveReport implicit_fixed_point(const ImplicitSystem& system, const SolveLimits& limits, VectorXd& y) {
  Solver solver(system, limits, y);
  SolveReport report;
  VectorXd x = y, frozen = VectorXd::Zero(y.size());
  double least = solver.residual(y, nullptr);
  while (least > limits.tolerance && report.iterations < limits.iterations && solver.seconds() <= limits.seconds) {
    if (!solver.newton(x, &frozen, 0.1 * limits.tolerance, nullptr)) break;
    frozen = x;
    const double current = solver.residual(x, nullptr);
    ++report.iterations;
    report.residuals.push_back(current);
    if (current < least) {
      least = current;
      y = x;
    }
  }
  return solver.finish(report, nullptr);
}

SolveReport linearised_step(const ImplicitSystem& system, const SolveLimits& limits, VectorXd& y) {
  Solver solver(system, limits, y);
  SolveReport report;
  const VectorXd start = VectorXd::Zero(y.size());
  solver.newton(y, &start, limits.tolerance, &report);
  return solver.finish(report, &start);
}

ImplicitSystem moved(const ImplicitSystem& system, const VectorXd& y) {
  ImplicitSystem result = system;
  Index next = 0;
  for (ImplicitBody& body : result.bodies) {
    if (!(body.mass > 0)) continue;
    body.v = y.segment<3>(next);
    body.w = y.segment<3>(next + 3);
    body.x += system.dt * body.v;
    const Vector3d half = 0.5 * system.dt * body.w;
    body.q = (Eigen::Quaterniond(1, half.x(), half.y(), half.z()) * body.q).normalized();
    next += 6;
  }
  return result;
}

double gap(const ImplicitSystem& system, std::size_t contact) {
  const SurfaceContact& c = system.contacts[contact];
  return contact_at<double>(c, start_of(system.bodies[c.body_a]), start_of(system.bodies[c.body_b]), Vector3d::Ones())
      .gap;
}

double joint_error(const ImplicitSystem& system, std::size_t joint) {
  const ImplicitJoint& j = system.joints[joint];
  return joint_at<double>(j, start_of(system.bodies[j.body_a]), start_of(system.bodies[j.body_b])).error.norm();
}

}  // namespace lockstep::oracle::models
