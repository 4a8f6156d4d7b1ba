#include "host/report/residual.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace lockstep {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// What an impulse at `arm` does to the velocity of the point at `arm`, per unit of impulse.
Matrix3d point_mobility(const SystemBody& body, const Vector3d& arm) {
  const Matrix3d r = cross_matrix(arm);
  return body.inverse_mass * Matrix3d::Identity() + r * body.inverse_inertia * r.transpose();
}

// Relative velocity at the ends of the arms of a contact or a patch, a against b.
template <class At>
Vector3d relative_velocity(const At& at, const Vector3d& v_a, const Vector3d& w_a, const Vector3d& v_b,
                           const Vector3d& w_b) {
  return v_a + w_a.cross(at.arm_a) - v_b - w_b.cross(at.arm_b);
}

// The impulse and the moment of all rows of a joint on b, or of the locked ones alone.
Vector3d joint_impulse(const SystemJoint& j, bool with_free) {
  return push_of(j, j.impulse) + free_push_of(j, with_free ? whole_free_impulse(j) : 0);
}
Vector3d joint_moment(const SystemJoint& j, bool with_free) {
  return moment_of(j, j.impulse) + free_moment_of(j, with_free ? whole_free_impulse(j) : 0);
}

// What all impulses together did to the bodies, M^-1 J^T r, and the sizes of what was added up.
struct Change {
  Vector3d v = Vector3d::Zero(), w = Vector3d::Zero();
  double v_size = 0, w_size = 0;

  void add(const SystemBody& body, const Vector3d& arm, const Vector3d& impulse,
           const Vector3d& moment = Vector3d::Zero()) {
    const Vector3d dv = body.inverse_mass * impulse;
    const Vector3d dw = body.inverse_inertia * (arm.cross(impulse) + moment);
    v += dv;
    w += dw;
    v_size += dv.norm();
    w_size += dw.norm();
  }
};

std::vector<Change> changes(const ContactSystem& system) {
  std::vector<Change> result(system.bodies.size());
  for (std::size_t i = 0; i < system.angular_friction.size(); ++i) {
    const SystemContact& c = system.contacts[i];
    const SystemAngularFriction& angular = system.angular_friction[i];
    const Vector3d moment = angular.torsion_radius * angular.torsion * c.normal + angular.roll;
    result[c.body_a].add(system.bodies[c.body_a], Vector3d::Zero(), Vector3d::Zero(), moment);
    result[c.body_b].add(system.bodies[c.body_b], Vector3d::Zero(), Vector3d::Zero(), -moment);
  }
  for (const SystemContact& c : system.contacts) {
    const Vector3d impulse = system.patches.empty() ? c.impulse : Vector3d(c.impulse.dot(c.normal) * c.normal);
    result[c.body_a].add(system.bodies[c.body_a], c.arm_a, impulse);
    result[c.body_b].add(system.bodies[c.body_b], c.arm_b, -impulse);
  }
  for (const SystemPatch& p : system.patches) {
    const SystemContact& c = system.contacts[p.first];
    result[c.body_a].add(system.bodies[c.body_a], p.arm_a, p.impulse, p.twist * p.normal);
    result[c.body_b].add(system.bodies[c.body_b], p.arm_b, -p.impulse, -p.twist * p.normal);
  }
  for (const SystemJoint& j : system.joints) {
    const Vector3d p = joint_impulse(j, true), m = joint_moment(j, true);
    result[j.body_a].add(system.bodies[j.body_a], j.arm_a, -p, -m);
    result[j.body_b].add(system.bodies[j.body_b], j.arm_b, p, m);
  }
  return result;
}

// F = r - P_K(r - rho u^), with De Saxce's u^ = u + mu |u_t| n; of the convex relaxation u^ = u.
Vector3d defect(const SystemContact& c, const Vector3d& u, double rho, bool convex) {
  const Vector3d u_t = u - u.dot(c.normal) * c.normal;
  const Vector3d u_hat = convex ? u : Vector3d(u + c.friction * u_t.norm() * c.normal);
  return c.impulse - project_on_cone(c.impulse - rho * u_hat, c.normal, c.friction);
}

// The nearest point of the cone, with any number of tangents.
template <class Vector>
Vector project(const Vector& impulse, const Vector& normal, double friction) {
  const double n = impulse.dot(normal);
  const Vector tangent = impulse - n * normal;
  const double t = tangent.norm();
  if (n >= 0 && t <= friction * n) return impulse;  // inside
  if (friction * t <= -n) return Vector::Zero();    // in the polar cone
  const double on_cone = (n + friction * t) / (1 + friction * friction);
  if (t == 0) return on_cone * normal;
  return on_cone * (normal + friction / t * tangent);
}

// The impulse of a contact and, where it has angular friction, of its torsion; or their velocities.
using Vector4d = Eigen::Vector4d;
Vector4d with_torsion(const Vector3d& of_contact, double torsion) {
  return {of_contact[0], of_contact[1], of_contact[2], torsion};
}

// F of a cone of slip and torsion, the same law with one tangent more.
Vector4d torsion_defect(const SystemContact& c, const SystemAngularFriction& angular, const Vector4d& u, double rho) {
  const Vector4d n = with_torsion(c.normal, 0), r = with_torsion(c.impulse, angular.torsion);
  const Vector4d u_hat = u + c.friction * (u - u.dot(n) * n).norm() * n;
  return r - project(Vector4d(r - rho * u_hat), n, c.friction);
}

// What the blocks of a system add up to.
struct Sums {
  double w = 0, q = 0, wr = 0, f = 0;  // of squares
  double largest = 0;                  // of the sizes of what impulses add to one block's velocity
  double count = 0;
  double last = 0;  // the largest defect velocity of the last contact or joint
  DefectVelocities each;
};

void add_contact(const SystemContact& c, bool convex, const SystemBody& a, const SystemBody& b, const Change& da,
                 const Change& db, Sums& sums) {
  const Vector3d u = relative_velocity(c, a.v, a.w, b.v, b.w) + c.bias * c.normal + c.slide;
  const Vector3d wr = relative_velocity(c, da.v, da.w, db.v, db.w);
  sums.q += (u - wr).squaredNorm();
  sums.wr += wr.squaredNorm();
  sums.f += defect(c, u, 1, convex).squaredNorm();
  sums.largest =
      std::max(sums.largest, da.v_size + da.w_size * c.arm_a.norm() + db.v_size + db.w_size * c.arm_b.norm());
  sums.count += 1;

  const Matrix3d w_ii = point_mobility(a, c.arm_a) + point_mobility(b, c.arm_b);
  const double lambda_max = Eigen::SelfAdjointEigenSolver<Matrix3d>(w_ii, Eigen::EigenvaluesOnly).eigenvalues()(2);
  if (lambda_max <= 0) return;  // two immovable bodies: nothing that an impulse could change
  const double w = defect(c, u, 1 / lambda_max, convex).norm() * lambda_max;
  sums.w += w * w;
  sums.last = w;
}

// A contact with angular friction: slip and torsion are one cone, rolling is a disc whose velocity becomes that of the
// mass at its radius of gyration.
void add_angular_friction(const SystemContact& c, const SystemAngularFriction& angular, const SystemBody& a,
                          const SystemBody& b, const Change& da, const Change& db, Sums& sums) {
  const auto cone_velocity = [&](const Vector3d& v_a, const Vector3d& w_a, const Vector3d& v_b, const Vector3d& w_b) {
    return with_torsion(relative_velocity(c, v_a, w_a, v_b, w_b), angular.torsion_radius * c.normal.dot(w_a - w_b));
  };
  // of a cone that is not round all is told as it is where it is
  Eigen::Matrix4d e = Eigen::Matrix4d::Identity();
  e.topLeftCorner<3, 3>() = angular.stretch;
  SystemContact round = c;
  // friction along one direction alone has no impulse across it: any inverse there will do
  round.impulse = angular.stretch.completeOrthogonalDecomposition().pseudoInverse() * c.impulse;
  const Vector4d u = e * (cone_velocity(a.v, a.w, b.v, b.w) + with_torsion(c.bias * c.normal + c.slide, 0));
  const Vector4d wr = e * cone_velocity(da.v, da.w, db.v, db.w);
  sums.q += (u - wr).squaredNorm();
  sums.wr += wr.squaredNorm();
  sums.f += torsion_defect(round, angular, u, 1).squaredNorm();
  sums.largest =
      std::max(sums.largest, da.v_size + da.w_size * c.arm_a.norm() + db.v_size + db.w_size * c.arm_b.norm());
  sums.count += 1;

  const Matrix3d angular_mobility = a.inverse_inertia + b.inverse_inertia;
  Eigen::Matrix4d w_ii = Eigen::Matrix4d::Zero();
  w_ii.topLeftCorner<3, 3>() = point_mobility(a, c.arm_a) + point_mobility(b, c.arm_b);
  const Vector3d response_a = angular.torsion_radius * a.inverse_inertia * c.normal;
  const Vector3d response_b = angular.torsion_radius * b.inverse_inertia * c.normal;
  w_ii.topRightCorner<3, 1>() = response_a.cross(c.arm_a) + response_b.cross(c.arm_b);
  w_ii.bottomLeftCorner<1, 3>() = w_ii.topRightCorner<3, 1>().transpose();
  w_ii(3, 3) = angular.torsion_radius * c.normal.dot(response_a + response_b);
  const double lambda_max =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(e * w_ii * e, Eigen::EigenvaluesOnly).eigenvalues()(3);
  if (lambda_max <= 0) return;  // two immovable bodies
  sums.last = torsion_defect(round, angular, u, 1 / lambda_max).norm() * lambda_max;
  sums.w += sums.last * sums.last;
  if (angular.rolling_coefficient == 0) return;

  const Matrix3d plane = Matrix3d::Identity() - c.normal * c.normal.transpose();
  const double angular_mobility_max =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(plane * angular_mobility * plane, Eigen::EigenvaluesOnly)
          .eigenvalues()(2);
  if (angular_mobility_max <= 0) return;
  const double radius = std::sqrt((a.inverse_mass + b.inverse_mass) / angular_mobility_max);
  const double limit = angular.rolling_coefficient * c.impulse.dot(c.normal);
  const Vector3d rolling = plane * (a.w - b.w), rolling_wr = plane * (da.w - db.w);
  const auto roll = [&](double rho) {
    const Vector3d t = angular.roll - rho * rolling;
    const double length = t.norm();
    return (angular.roll - (length > limit ? limit / length : 1) * t).norm();
  };
  const double w = radius * angular_mobility_max * roll(1 / angular_mobility_max);
  sums.w += w * w;
  sums.q += radius * radius * (rolling - rolling_wr).squaredNorm();
  sums.wr += radius * radius * rolling_wr.squaredNorm();
  sums.f += roll(1) * roll(1);
  sums.count += 1;
  sums.last = std::max(sums.last, w);
}

// The normal row of each contact; one friction block and one twist, bounded by what presses. The twist's velocity
// becomes that of the mass at its radius of gyration.
void add_patch(const SystemPatch& p, std::span<const SystemContact> contacts, const SystemBody& a, const SystemBody& b,
               const Change& da, const Change& db, Sums& sums) {
  const auto add = [&](double w, double q, double from_impulses, double f) {
    sums.w += w * w;
    sums.q += q * q;
    sums.wr += from_impulses * from_impulses;
    sums.f += f * f;
    sums.count += 1;
    sums.last = std::max(sums.last, w);
  };
  double load = 0, moment = 0;
  for (u32 k = 0; k < p.count; ++k) {
    const SystemContact& c = contacts[p.first + k];
    const double r = c.impulse.dot(c.normal);
    load += r;
    moment += p.distances[k] * r;
    const double w_nn = c.normal.dot((point_mobility(a, c.arm_a) + point_mobility(b, c.arm_b)) * c.normal);
    const double u = c.normal.dot(relative_velocity(c, a.v, a.w, b.v, b.w)) + c.bias;
    const double wr = c.normal.dot(relative_velocity(c, da.v, da.w, db.v, db.w));
    const double f = r - std::max(0.0, r - u), w = w_nn > 0 ? w_nn * (r - std::max(0.0, r - u / w_nn)) : 0;
    add(w, u - wr, wr, f);
    sums.largest =
        std::max(sums.largest, da.v_size + da.w_size * c.arm_a.norm() + db.v_size + db.w_size * c.arm_b.norm());
  }
  const Matrix3d plane = Matrix3d::Identity() - p.normal * p.normal.transpose();
  const Matrix3d w_tt = plane * (point_mobility(a, p.arm_a) + point_mobility(b, p.arm_b)) * plane;
  const double lambda_max = Eigen::SelfAdjointEigenSolver<Matrix3d>(w_tt, Eigen::EigenvaluesOnly).eigenvalues()(2);
  const Vector3d u = plane * relative_velocity(p, a.v, a.w, b.v, b.w);
  const Vector3d wr = plane * relative_velocity(p, da.v, da.w, db.v, db.w);
  const auto friction_defect = [&](double rho) {
    const Vector3d t = p.impulse - rho * u;
    const double limit = p.friction * load, length = t.norm();
    return (p.impulse - (length > limit ? limit / length : 1) * t).norm();
  };
  if (lambda_max > 0) add(lambda_max * friction_defect(1 / lambda_max), (u - wr).norm(), wr.norm(), friction_defect(1));

  const double w_twist = p.normal.dot((a.inverse_inertia + b.inverse_inertia) * p.normal);
  if (p.count < 2 || w_twist <= 0) return;
  const double radius = std::sqrt((a.inverse_mass + b.inverse_mass) / w_twist);
  const double twist_rate = p.normal.dot(a.w - b.w), twist_rate_wr = p.normal.dot(da.w - db.w);
  const double twist_limit = p.friction * moment;
  const auto twist = [&](double rho) {
    return std::abs(p.twist - std::clamp(p.twist - rho * twist_rate, -twist_limit, twist_limit));
  };
  add(radius * w_twist * twist(1 / w_twist), radius * (twist_rate - twist_rate_wr), radius * twist_rate_wr, twist(1));
}

// The velocities of the rows of a joint, b against a, and that of its free row.
struct JointRows {
  Rows locked;
  double free = 0;
};

JointRows joint_rows(const SystemJoint& j, const Vector3d& v_a, const Vector3d& w_a, const Vector3d& v_b,
                     const Vector3d& w_b) {
  const Vector3d u = v_b + w_b.cross(j.arm_b) - v_a - w_a.cross(j.arm_a);
  const Vector3d relative_w = w_b - w_a;
  JointRows rows;
  rows.locked << j.axes.transpose() * u, j.axes.transpose() * relative_w;
  rows.locked[2] -= j.lead * rows.locked[5];
  for (u32 i = 0; i < JOINT_ROWS; ++i) {
    if ((j.locked >> i & 1) == 0) rows.locked[i] = 0;
  }
  rows.free = j.free_axis.dot(j.free == FREE_ANGLE ? relative_w : u);
  return rows;
}

// K r of the locked rows: what their own impulses do to them.
Rows own_velocity(const SystemJoint& j, const SystemBody& a, const SystemBody& b) {
  const Vector3d p = joint_impulse(j, false), m = joint_moment(j, false);
  return joint_rows(j, -a.inverse_mass * p, -a.inverse_inertia * (j.arm_a.cross(p) + m), b.inverse_mass * p,
                    b.inverse_inertia * (j.arm_b.cross(p) + m))
      .locked;
}

// The velocity that the law of the free row wants, q + e r where r is what the motor and the bounds make of it.
double wanted_speed(const SystemJoint& j, double u) {
  const double e = j.effective_mobility, q = u - e * j.free_impulse;
  if (j.spring_compliance > 0) {
    if (j.motor_impulse < 0) {
      const double alone = (j.slowest - q) / (e + j.spring_compliance);
      return q + e * std::clamp(alone, j.motor_speed + j.motor_impulse, j.motor_speed - j.motor_impulse);
    }
    const double left = j.spring_compliance / (e + j.spring_compliance), idle = j.slowest + left * (q - j.slowest);
    const double motor_change = left * e * j.motor_impulse;
    return std::clamp(j.motor_speed, idle - motor_change, idle + motor_change);
  }
  const double motor_change = e * j.motor_impulse;
  const double driven = std::clamp(j.motor_speed, q - motor_change, q + motor_change);
  return driven + (std::clamp(driven, j.slowest, j.fastest) - driven) / (1 + j.bound_softness);
}

// Linear, angular and free rows are a block each; angular velocities become those of the mass at its radius of
// gyration.
void add_joint(const SystemJoint& j, const SystemBody& a, const SystemBody& b, const Change& da, const Change& db,
               Sums& sums) {
  const JointRows u = joint_rows(j, a.v, a.w, b.v, b.w), wr = joint_rows(j, da.v, da.w, db.v, db.w);
  Rows defect = u.locked + j.softness * own_velocity(j, a, b);
  for (u32 i = 0; i < JOINT_ROWS; ++i) defect[i] += (j.locked >> i & 1) != 0 ? j.bias[i] : 0;
  const Matrix3d angular_mobility = a.inverse_inertia + b.inverse_inertia;
  const double angular_mobility_max =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(angular_mobility, Eigen::EigenvaluesOnly).eigenvalues()(2);
  const double inverse_mass = a.inverse_mass + b.inverse_mass;
  const double radius = angular_mobility_max > 0 ? std::sqrt(inverse_mass / angular_mobility_max) : 0;
  const auto add = [&](double w, double q, double from_impulses, double rho) {
    sums.w += w * w;
    sums.q += q * q;
    sums.wr += from_impulses * from_impulses;
    sums.f += rho * rho * w * w;
    sums.count += 1;
    sums.last = std::max(sums.last, w);
  };
  sums.largest =
      std::max(sums.largest, da.v_size + da.w_size * j.arm_a.norm() + db.v_size + db.w_size * j.arm_b.norm());
  const Rows free_of_impulses = defect - wr.locked;
  if ((j.locked & 7) != 0)
    add(defect.head<3>().norm(), free_of_impulses.head<3>().norm(), wr.locked.head<3>().norm(), 1);
  if ((j.locked >> 3) != 0)
    add(radius * defect.tail<3>().norm(), radius * free_of_impulses.tail<3>().norm(),
        radius * wr.locked.tail<3>().norm(), 1);
  const bool bounded = j.slowest > -double(JOINT_UNBOUNDED) || j.fastest < double(JOINT_UNBOUNDED);
  const bool angular = j.free == FREE_ANGLE;
  const double size = angular ? radius : 1;
  if (j.impedance_compliance > 0) {
    // by how much a solve of its row alone would change the velocity
    const double off = u.free - j.impedance_speed + j.impedance_compliance * j.impedance_impulse;
    const double share = j.effective_mobility / j.impedance_compliance;
    add(size * share * std::abs(off), size * std::abs(u.free - wr.free), size * std::abs(wr.free), 1);
  }
  if (j.free == FREE_NOTHING || !(bounded || j.motor_impulse > 0)) return;
  add(size * std::abs(u.free - wanted_speed(j, u.free)), size * std::abs(u.free - wr.free), size * std::abs(wr.free),
      1);
}

Sums sums_of(const ContactSystem& system) {
  const std::vector<Change> change = changes(system);
  Sums sums;
  sums.each = {std::vector<double>(system.contacts.size(), 0.0), std::vector<double>(system.joints.size(), 0.0)};
  for (const SystemPatch& p : system.patches) {
    const SystemContact& c = system.contacts[p.first];
    add_patch(p, system.contacts, system.bodies[c.body_a], system.bodies[c.body_b], change[c.body_a], change[c.body_b],
              sums);
    sums.each.contacts[p.first] = std::exchange(sums.last, 0);
  }
  for (u32 i = 0; i < (system.patches.empty() ? system.contacts.size() : 0); ++i) {
    const SystemContact& c = system.contacts[i];
    const SystemBody &a = system.bodies[c.body_a], &b = system.bodies[c.body_b];
    if (system.angular_friction.empty())
      add_contact(c, system.convex, a, b, change[c.body_a], change[c.body_b], sums);
    else
      add_angular_friction(c, system.angular_friction[i], a, b, change[c.body_a], change[c.body_b], sums);
    sums.each.contacts[i] = std::exchange(sums.last, 0);
  }
  for (u32 i = 0; i < system.joints.size(); ++i) {
    const SystemJoint& j = system.joints[i];
    add_joint(j, system.bodies[j.body_a], system.bodies[j.body_b], change[j.body_a], change[j.body_b], sums);
    sums.each.joints[i] = std::exchange(sums.last, 0);
  }
  return sums;
}

// The first of the largest, contacts before joints.
void find_worst(const DefectVelocities& each, Residual& result) {
  result.worst_is_joint = each.contacts.empty();
  const auto look = [&](const std::vector<double>& defects, bool is_joint) {
    for (u32 i = 0; i < defects.size(); ++i) {
      if (!(defects[i] > result.defect_max)) continue;
      result.defect_max = defects[i];
      result.worst = i;
      result.worst_is_joint = is_joint;
    }
  };
  look(each.contacts, false);
  look(each.joints, true);
}

}  // namespace

DefectVelocities defect_velocities(const ContactSystem& system) { return sums_of(system).each; }

Vector3d project_on_cone(const Vector3d& impulse, const Vector3d& normal, double friction) {
  return project(impulse, normal, friction);
}

Residual residual(const ContactSystem& system, double roundoff) {
  Residual result;
  if (system.contacts.empty() && system.joints.empty()) return result;
  const Sums sums = sums_of(system);
  find_worst(sums.each, result);
  result.defect_rms = std::sqrt(sums.w / sums.count);
  result.scale = sums.q > 0 ? std::sqrt(sums.q / sums.count) : std::sqrt(sums.wr / sums.count);
  if (result.scale > 0) {
    result.relative = result.defect_rms / result.scale;
    result.rounding = roundoff * sums.largest / result.scale;
  }
  if (sums.q > 0) result.natural_map = std::sqrt(sums.f / sums.q);
  if (!system.patches.empty() || (system.convex && !system.contacts.empty())) {
    ContactSystem canonical = system;
    canonical.patches.clear();
    canonical.convex = false;
    result.model_error = residual(canonical, roundoff).relative - result.relative;
  }
  return result;
}

}  // namespace lockstep
