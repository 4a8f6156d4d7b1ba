#include "cpu_reference/oracle/error.hpp"

#include <algorithm>
#include <cmath>

#include "cpu_reference/oracle/cone/cone.hpp"
#include "cpu_reference/oracle/dense.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Of a contact between immovable bodies, which no impulse could change, the defect is 0.
double defect_velocity(const Vector3d& r, const Vector3d& u, double mu, double mobility) {
  return mobility > 0 ? mobility * natural_map(r, u, mu, 1 / mobility).norm() : 0;
}

double ratio(double a, double b) { return b > 0 ? a / b : 0; }

// Alart and Curnier's function, and Jean and Moreau's where the disc is that of r_n itself.
Vector3d projected(const Vector3d& r, const Vector3d& u, double mu, bool of_impulse) {
  const double n = std::max(0.0, r[0] - u[0]), radius = mu * (of_impulse ? std::max(0.0, r[0]) : n);
  Vector3d phi(r[0] - n, 0, 0);
  phi.tail<2>() = r.tail<2>() - project_on_disc(r.tail<2>() - u.tail<2>(), radius);
  return phi;
}

}  // namespace

ResidualMeter::ResidualMeter(const ConeProblem& problem) : problem_(problem), mobility_(problem.contacts()) {
  for (std::uint32_t i = 0; i < problem.contacts(); ++i)
    mobility_[i] = largest_eigenvalue(problem.w.symmetric_diagonal(i));
  q_rms_ = problem.contacts() > 0 ? problem.q.norm() / std::sqrt(double(problem.contacts())) : 0;
}

double ResidualMeter::residual(const VectorXd& r, const VectorXd& u) const {
  if (problem_.contacts() == 0) return 0;
  double sum = 0;
  for (std::uint32_t i = 0; i < problem_.contacts(); ++i) {
    const double w = defect_velocity(r.segment<3>(3 * i), u.segment<3>(3 * i), problem_.mu[i], mobility_[i]);
    sum += w * w;
  }
  const double count = problem_.contacts();
  return ratio(std::sqrt(sum / count), q_rms_ > 0 ? q_rms_ : (u - problem_.q).norm() / std::sqrt(count));
}

ConeError cone_error(const ConeProblem& problem, const VectorXd& r, const VectorXd& l) {
  ConeError error;
  const ResidualMeter meter(problem);
  const std::uint32_t n = problem.contacts();
  VectorXd change = problem.w.times(r);
  if (problem.joints) change += problem.joints->v * l;
  const VectorXd u = change + problem.q;

  double w_sum = 0, q_sum = problem.q.squaredNorm(), change_sum = change.squaredNorm(), count = n;
  double f = 0, alart_curnier = 0, jean_moreau = 0, largest = 0;
  const auto add = [&](double w, std::uint32_t block) {
    w_sum += w * w;
    if (w > error.defect_max) {
      error.defect_max = w;
      error.worst = block;
    }
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vector3d r_i = r.segment<3>(3 * i), u_i = u.segment<3>(3 * i);
    const double mu = problem.mu[i];
    add(defect_velocity(r_i, u_i, mu, meter.mobility()[i]), i);
    f += natural_map(r_i, u_i, mu, 1).squaredNorm();
    alart_curnier += projected(r_i, u_i, mu, false).squaredNorm();
    jean_moreau += projected(r_i, u_i, mu, true).squaredNorm();
    double size = 0;
    for (std::uint32_t k = problem.w.first[i]; k < problem.w.first[i + 1]; ++k)
      size += problem.w.block[k].norm() * r.segment<3>(3 * problem.w.column[k]).norm();
    largest = std::max(largest, size);
  }
  double joint_norm = 0, s_norm = 0;
  if (problem.joints) {
    const Bilateral& joints = *problem.joints;
    const VectorXd joint_change = joints.v.transpose() * r + joints.r * l, v = joint_change + joints.s;
    for (std::size_t k = 0; k + 1 < joints.first.size(); ++k) {
      add(v.segment(joints.first[k], joints.first[k + 1] - joints.first[k]).norm(), n + static_cast<std::uint32_t>(k));
      count += 1;
    }
    q_sum += joints.s.squaredNorm();
    change_sum += joint_change.squaredNorm();
    joint_norm = v.norm();
    s_norm = joints.s.norm();
  }
  if (count == 0) return error;
  error.defect_rms = std::sqrt(w_sum / count);
  error.scale = std::sqrt((q_sum > 0 ? q_sum : change_sum) / count);
  error.residual = ratio(error.defect_rms, error.scale);
  error.rounding = ratio(0x1p-53 * largest, error.scale);
  const double q_norm = problem.q.norm();
  error.natural_map = ratio(std::sqrt(f), q_norm);
  error.natural_largest = ratio(std::sqrt(f), std::max({q_norm, r.norm(), u.norm()}));
  error.alart_curnier = ratio(std::sqrt(alart_curnier), q_norm);
  error.jean_moreau = ratio(std::sqrt(jean_moreau), q_norm);
  error.merit_1 = std::sqrt(f) / (1 + std::sqrt(q_norm)) + joint_norm / (1 + s_norm);
  return error;
}

}  // namespace lockstep::oracle
