// The equations of implicit_step.hpp, for numbers and for numbers with derivatives: all of them at the step's end, or
// with poses held at an iterate, and gaps and joints linearised there.
#pragma once

#include <cmath>

#include "cpu_reference/oracle/models/implicit_step.hpp"

namespace lockstep::oracle::models {

template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Mat3 = Eigen::Matrix<T, 3, 3>;

inline double value_of(double x) { return x; }
template <class T>
double value_of(const T& x) {
  return x.value();
}

/// Numbers as those of another kind, without derivatives.
template <class T, class Derived>
Eigen::Matrix<T, Derived::RowsAtCompileTime, Derived::ColsAtCompileTime> as(const Eigen::MatrixBase<Derived>& m) {
  return m.template cast<T>();
}

template <class T>
T root(const T& x) {
  using std::sqrt;
  return T(sqrt(x));
}

template <class T>
struct BodyAt {
  Vec3<T> x, v, w;
  Mat3<T> r;
};

/// (1 + dt/2 w) Q, normalised, as a matrix.
template <class T>
Mat3<T> turned(const Eigen::Quaterniond& q, const Vec3<T>& w, double dt) {
  const Vec3<T> half = w * T(0.5 * dt), im = as<T>(q.vec());
  const T re = T(T(q.w()) - half.dot(im));
  const Vec3<T> v = half * T(q.w()) + im + half.cross(im);
  const T two = T(T(2) / T(re * re + v.dot(v)));
  Mat3<T> cross;
  cross << T(0), T(-v[2]), v[1], v[2], T(0), T(-v[0]), T(-v[1]), v[0], T(0);
  const Mat3<T> square = cross * cross;  // R = 1 + 2 (re [v] + [v]^2) / |Q|^2
  return Mat3<T>::Identity() + (cross * re + square) * two;
}

/// A body at the end of a step with these velocities.
template <class T>
BodyAt<T> body_at(const ImplicitBody& body, const Vec3<T>& v, const Vec3<T>& w, double dt) {
  return {as<T>(body.x) + v * T(dt), v, w, turned(body.q, w, dt)};
}

/// What a contact is at a pose. The normal is from b to a.
template <class T>
struct ContactAt {
  T gap;
  Vec3<T> normal, tangent_1, tangent_2, arm_a, arm_b;
};

/// `across`: the first tangent is what is left of it in the tangent plane.
template <class T>
ContactAt<T> contact_at(const SurfaceContact& c, const BodyAt<T>& a, const BodyAt<T>& b, const Vector3d& across) {
  const Vec3<T> centre = a.r * as<T>(c.centre_a), on_b = b.r * as<T>(c.point_b);
  const Vec3<T> d = a.x + centre - b.x - on_b;
  ContactAt<T> at;
  if (c.surface == Surface::plane) {
    at.normal = b.r * as<T>(c.normal_b);
    at.gap = T(at.normal.dot(d) - T(c.radius_a));
  } else {
    const T distance = root(T(d.dot(d))), sign = T(c.surface == Surface::ball ? 1 : -1);
    at.normal = d * T(sign / distance);
    at.gap = T(sign * T(distance - T(c.radius_b)) - T(c.radius_a));
  }
  at.arm_a = centre - at.normal * T(c.radius_a);
  at.arm_b = a.x + at.arm_a - b.x;
  const Vec3<T> first = as<T>(across) - at.normal * T(at.normal.dot(as<T>(across)));
  at.tangent_1 = first * T(T(1) / root(T(first.dot(first))));
  at.tangent_2 = at.normal.cross(at.tangent_1);
  return at;
}

/// What a joint is at a pose: by how far it is open, and the directions about which a hinge may not turn.
template <class T>
struct JointAt {
  Vec3<T> error, arm_a, arm_b, axis, across_1, across_2;
  T tilt_1, tilt_2;  // axis_a . across_1, axis_a . across_2: sines
};

template <class T>
JointAt<T> joint_at(const ImplicitJoint& j, const BodyAt<T>& a, const BodyAt<T>& b) {
  JointAt<T> at;
  at.arm_a = a.r * as<T>(j.anchor_a);
  at.arm_b = b.r * as<T>(j.anchor_b);
  at.error = a.x + at.arm_a - b.x - at.arm_b;
  const Eigen::Matrix<double, 3, 2> across = tangents(j.axis_b);
  at.axis = a.r * as<T>(j.axis_a);
  const Vec3<T> first = b.r * as<T>(across.col(0)), second = b.r * as<T>(across.col(1));
  at.tilt_1 = at.axis.dot(first);
  at.tilt_2 = at.axis.dot(second);
  // d/dt (axis_a . first) = (w_a - w_b) . (axis_a x first)
  at.across_1 = at.axis.cross(first);
  at.across_2 = at.axis.cross(second);
  return at;
}

/// The velocity of a against b at the ends of two arms.
template <class T>
Vec3<T> velocity_between(const BodyAt<T>& a, const Vec3<T>& arm_a, const BodyAt<T>& b, const Vec3<T>& arm_b) {
  return a.v + a.w.cross(arm_a) - b.v - b.w.cross(arm_b);
}

/// A velocity that counts in m/s what a row is violated by, whatever the row's unit; and rho of (42) to (44).
struct RowSizes {
  std::vector<double> mobility;  // of contacts, 1 / rho, 1/kg
  std::vector<double> radius;    // of gyration, of the two bodies of a joint, m
  std::vector<Vector3d> across;  // of contacts, what the first tangent is made of
};

/// The left side of all equations in m/s, in the order of the unknowns. `held`: the y at which the step is linearised;
/// null: the nonlinear step.
template <class T>
Eigen::Matrix<T, Eigen::Dynamic, 1> equations(const ImplicitSystem& system, const RowSizes& sizes,
                                              const Eigen::Matrix<T, Eigen::Dynamic, 1>& y, const VectorXd* held) {
  const double dt = system.dt;
  std::vector<BodyAt<T>> now, before;  // before: with the velocities that led to the held pose
  std::vector<Vec3<T>> push, twist;    // impulses and moments about the centre of mass
  Index next = 0;
  for (const ImplicitBody& body : system.bodies) {
    const bool moves = body.mass > 0;
    const Vec3<T> v = moves ? Vec3<T>(y.template segment<3>(next)) : as<T>(Vector3d::Zero());
    const Vec3<T> w = moves ? Vec3<T>(y.template segment<3>(next + 3)) : as<T>(Vector3d::Zero());
    now.push_back(body_at<T>(body, v, w, dt));
    if (held) {
      const Vector3d held_v = moves ? Vector3d(held->segment<3>(next)) : Vector3d(Vector3d::Zero());
      const Vector3d held_w = moves ? Vector3d(held->segment<3>(next + 3)) : Vector3d(Vector3d::Zero());
      before.push_back(body_at<T>(body, as<T>(held_v), as<T>(held_w), dt));
      now.back().x = before.back().x;
      now.back().r = before.back().r;
    }
    push.push_back(as<T>(Vector3d(dt * body.force)));
    twist.push_back(as<T>(Vector3d(dt * body.torque)));
    next += moves ? 6 : 0;
  }
  Eigen::Matrix<T, Eigen::Dynamic, 1> f(y.size());
  const auto give = [&](std::size_t body, const Vec3<T>& arm, const Vec3<T>& impulse, const Vec3<T>& moment) {
    push[body] += impulse;
    twist[body] += arm.cross(impulse) + moment;
  };
  const Vec3<T> none = as<T>(Vector3d::Zero());

  for (std::size_t i = 0; i < system.contacts.size(); ++i, next += 3) {
    const SurfaceContact& contact = system.contacts[i];
    const BodyAt<T>&a = now[contact.body_a], &b = now[contact.body_b];
    ContactAt<T> c = contact_at(contact, a, b, sizes.across[i]);
    const Vec3<T> u = velocity_between(a, c.arm_a, b, c.arm_b);
    if (held) {
      const Vec3<T> then = velocity_between(before[contact.body_a], c.arm_a, before[contact.body_b], c.arm_b);
      c.gap = T(c.gap + T(dt) * T(c.normal.dot(u - then)));
    }
    const T closing = T(c.gap / T(dt)), rho = T(1 / sizes.mobility[i]);
    const T p_n = y[next], p_1 = y[next + 1], p_2 = y[next + 2];
    const T nu_1 = T(c.tangent_1.dot(u)), nu_2 = T(c.tangent_2.dot(u));
    const T x_n = T(p_n - rho * closing), x_1 = T(p_1 - rho * nu_1), x_2 = T(p_2 - rho * nu_2);
    const bool touches = value_of(x_n) > 0;
    const double radius = touches ? contact.friction * value_of(x_n) : 0;
    const double length = std::hypot(value_of(x_1), value_of(x_2));
    f[next] = touches ? closing : T(p_n / rho);
    if (length <= radius && touches) {
      f[next + 1] = nu_1;
      f[next + 2] = nu_2;
    } else if (touches && length > 0) {
      const T share = T(T(contact.friction) * x_n / root(T(x_1 * x_1 + x_2 * x_2)));
      f[next + 1] = T(T(p_1 - share * x_1) / rho);
      f[next + 2] = T(T(p_2 - share * x_2) / rho);
    } else {
      f[next + 1] = T(p_1 / rho);
      f[next + 2] = T(p_2 / rho);
    }
    const Vec3<T> impulse = c.normal * p_n + c.tangent_1 * p_1 + c.tangent_2 * p_2;
    give(contact.body_a, c.arm_a, impulse, none);
    give(contact.body_b, c.arm_b, -impulse, none);
  }

  for (std::size_t i = 0; i < system.joints.size(); ++i) {
    const ImplicitJoint& joint = system.joints[i];
    const BodyAt<T>&a = now[joint.body_a], &b = now[joint.body_b];
    JointAt<T> j = joint_at(joint, a, b);
    const Vec3<T> u = velocity_between(a, j.arm_a, b, j.arm_b), turn = a.w - b.w;
    if (held) {
      const BodyAt<T>&then_a = before[joint.body_a], &then_b = before[joint.body_b];
      const Vec3<T> du = u - velocity_between(then_a, j.arm_a, then_b, j.arm_b), dw = turn - then_a.w + then_b.w;
      j.error += du * T(dt);
      j.tilt_1 = T(j.tilt_1 + T(dt) * T(j.across_1.dot(dw)));
      j.tilt_2 = T(j.tilt_2 + T(dt) * T(j.across_2.dot(dw)));
    }
    f.template segment<3>(next) = j.error * T(1 / dt);
    const Vec3<T> impulse = y.template segment<3>(next);
    Vec3<T> moment = none;
    next += 3;
    if (joint.hinge) {
      const double radius = sizes.radius[i];
      f[next] = T(j.tilt_1 * T(radius / dt));
      f[next + 1] = T(j.tilt_2 * T(radius / dt));
      // rubbing: |p| <= dry dt, against the turning (44)
      const double rho = 1 / sizes.mobility[system.contacts.size() + i], most = dt * joint.dry;
      const T p = y[next + 2], nu = T(j.axis.dot(turn)), x = T(p - T(rho) * nu);
      const double over = std::abs(value_of(x)) - most;
      f[next + 2] = over <= 0 ? T(nu * T(radius)) : T(T(p - T(value_of(x) > 0 ? most : -most)) * T(radius / rho));
      moment = j.across_1 * y[next] + j.across_2 * y[next + 1] + j.axis * p;
      next += 3;
    }
    give(joint.body_a, j.arm_a, impulse, moment);
    give(joint.body_b, j.arm_b, -impulse, -moment);
  }

  next = 0;
  for (std::size_t k = 0; k < system.bodies.size(); ++k) {
    const ImplicitBody& body = system.bodies[k];
    if (!(body.mass > 0)) continue;
    const Mat3<T> half = now[k].r * as<T>(body.inertia), inertia = half * now[k].r.transpose();
    const Vec3<T> w = held ? before[k].w : now[k].w, spin = inertia * w;
    const Vec3<T> gained = inertia * (now[k].w - as<T>(body.w)) + w.cross(spin) * T(dt);
    const double turning = std::sqrt(body.mass * body.inertia.diagonal().maxCoeff());
    f.template segment<3>(next) = now[k].v - as<T>(body.v) - push[k] * T(1 / body.mass);
    f.template segment<3>(next + 3) = (gained - twist[k]) * T(1 / turning);
    next += 6;
  }
  return f;
}

}  // namespace lockstep::oracle::models
