#include "host/report/residual.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace lockstep {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

// What an impulse at `arm` does to the velocity of the point at `arm`, per unit of impulse.
Matrix3d point_mobility(const SystemBody& body, const Vector3d& arm) {
  const Matrix3d r = cross_matrix(arm);
  return body.inverse_mass * Matrix3d::Identity() + r * body.inverse_inertia * r.transpose();
}

// Relative velocity of the contact point, a against b.
Vector3d relative_velocity(const SystemContact& c, const Vector3d& v_a, const Vector3d& w_a, const Vector3d& v_b,
                           const Vector3d& w_b) {
  return v_a + w_a.cross(c.arm_a) - v_b - w_b.cross(c.arm_b);
}

// What all impulses together did to the bodies, M^-1 J^T r, and the sizes of what was added up.
struct Change {
  Vector3d v = Vector3d::Zero(), w = Vector3d::Zero();
  double v_size = 0, w_size = 0;

  void add(const SystemBody& body, const Vector3d& arm, const Vector3d& impulse) {
    const Vector3d dv = body.inverse_mass * impulse;
    const Vector3d dw = body.inverse_inertia * arm.cross(impulse);
    v += dv;
    w += dw;
    v_size += dv.norm();
    w_size += dw.norm();
  }
};

std::vector<Change> changes(const ContactSystem& system) {
  std::vector<Change> result(system.bodies.size());
  for (const SystemContact& c : system.contacts) {
    result[c.body_a].add(system.bodies[c.body_a], c.arm_a, c.impulse);
    result[c.body_b].add(system.bodies[c.body_b], c.arm_b, -c.impulse);
  }
  return result;
}

// F = r - P_K(r - rho u^), with De Saxce's u^ = u + mu |u_t| n.
Vector3d defect(const SystemContact& c, const Vector3d& u, double rho) {
  const Vector3d u_t = u - u.dot(c.normal) * c.normal;
  const Vector3d u_hat = u + c.friction * u_t.norm() * c.normal;
  return c.impulse - project_on_cone(c.impulse - rho * u_hat, c.normal, c.friction);
}

}  // namespace

Vector3d project_on_cone(const Vector3d& impulse, const Vector3d& normal, double friction) {
  const double n = impulse.dot(normal);
  const Vector3d tangent = impulse - n * normal;
  const double t = tangent.norm();
  if (n >= 0 && t <= friction * n) return impulse;  // inside
  if (friction * t <= -n) return Vector3d::Zero();  // in the polar cone
  const double on_cone = (n + friction * t) / (1 + friction * friction);
  if (t == 0) return on_cone * normal;
  return on_cone * (normal + friction / t * tangent);
}

Residual residual(const ContactSystem& system, double roundoff) {
  Residual result;
  if (system.contacts.empty()) return result;
  const std::vector<Change> change = changes(system);

  double sum_w = 0, sum_q = 0, sum_wr = 0, sum_f = 0, largest_sum = 0;
  for (u32 i = 0; i < system.contacts.size(); ++i) {
    const SystemContact& c = system.contacts[i];
    const SystemBody &a = system.bodies[c.body_a], &b = system.bodies[c.body_b];
    const Change &da = change[c.body_a], &db = change[c.body_b];

    const Vector3d u = relative_velocity(c, a.v, a.w, b.v, b.w) + c.bias * c.normal;
    const Vector3d wr = relative_velocity(c, da.v, da.w, db.v, db.w);
    const Vector3d q = u - wr;
    sum_q += q.squaredNorm();
    sum_wr += wr.squaredNorm();
    sum_f += defect(c, u, 1).squaredNorm();
    largest_sum =
        std::max(largest_sum, da.v_size + da.w_size * c.arm_a.norm() + db.v_size + db.w_size * c.arm_b.norm());

    const Matrix3d w_ii = point_mobility(a, c.arm_a) + point_mobility(b, c.arm_b);
    const double lambda_max = Eigen::SelfAdjointEigenSolver<Matrix3d>(w_ii, Eigen::EigenvaluesOnly).eigenvalues()(2);
    if (lambda_max <= 0) continue;  // two immovable bodies: nothing that an impulse could change
    const double w = defect(c, u, 1 / lambda_max).norm() * lambda_max;
    sum_w += w * w;
    if (w > result.defect_max) {
      result.defect_max = w;
      result.worst = i;
    }
  }

  const double count = static_cast<double>(system.contacts.size());
  result.defect_rms = std::sqrt(sum_w / count);
  result.scale = sum_q > 0 ? std::sqrt(sum_q / count) : std::sqrt(sum_wr / count);
  if (result.scale > 0) {
    result.relative = result.defect_rms / result.scale;
    result.rounding = roundoff * largest_sum / result.scale;
  }
  if (sum_q > 0) result.natural_map = std::sqrt(sum_f / sum_q);
  return result;
}

}  // namespace lockstep
