// The equations of implicit_step.hpp, for numbers and for numbers with derivatives: all of them at the step's end, or
// with poses frozen at an iterate, and gaps and joints linearised there.
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
Mat3<T> rotation_after(const Eigen::Quaterniond& q, const Vec3<T>& w, double dt) {
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
  return {as<T>(body.x) + v * T(dt), v, w, rotation_after(body.q, w, dt)};
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

/// The left side of all equations in m/s, in the order of the unknowns.
template <class T>
class Equations {
 public:
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;

  /// `frozen`: the y at which the step is linearised; null: the nonlinear step. All are kept by reference.
  Equations(const ImplicitSystem& system, const RowSizes& sizes, const Vector& y, const VectorXd* frozen)
      : system_(system), sizes_(sizes), y_(y), frozen_(frozen), f_(y.size()) {
    for (const ImplicitBody& body : system.bodies) add_body(body);
    for (std::size_t i = 0; i < system.contacts.size(); ++i) add_contact(i);
    for (std::size_t i = 0; i < system.joints.size(); ++i) add_joint(i);
    next_ = 0;
    for (std::size_t i = 0; i < system.bodies.size(); ++i) add_body(i);
  }

  const Vector& left_side() const { return f_; }

 private:
  Vec3<T> unknown(Index at) const { return y_.template segment<3>(at); }

  void add_body(const ImplicitBody& body) {
    const double dt = system_.dt;
    const bool moves = body.mass > 0;
    const Vec3<T> zero = as<T>(Vector3d::Zero());
    current_.push_back(moves ? body_at<T>(body, unknown(next_), unknown(next_ + 3), dt)
                             : body_at<T>(body, zero, zero, dt));
    if (frozen_) {
      const Vector3d v = moves ? frozen_->segment<3>(next_).eval() : Vector3d::Zero().eval();
      const Vector3d w = moves ? frozen_->segment<3>(next_ + 3).eval() : Vector3d::Zero().eval();
      before_.push_back(body_at<T>(body, as<T>(v), as<T>(w), dt));
      current_.back().x = before_.back().x;
      current_.back().r = before_.back().r;
    }
    push_.push_back(as<T>(Vector3d(dt * body.force)));
    twist_.push_back(as<T>(Vector3d(dt * body.torque)));
    next_ += moves ? 6 : 0;
  }

  void apply_impulse(std::size_t body, const Vec3<T>& arm, const Vec3<T>& impulse, const Vec3<T>& moment) {
    push_[body] += impulse;
    twist_[body] += arm.cross(impulse) + moment;
  }

  void add_contact(std::size_t i) {
    const SurfaceContact& contact = system_.contacts[i];
    const BodyAt<T>&a = current_[contact.body_a], &b = current_[contact.body_b];
    ContactAt<T> c = contact_at(contact, a, b, sizes_.across[i]);
    const Vec3<T> u = velocity_between(a, c.arm_a, b, c.arm_b);
    if (frozen_) {
      const Vec3<T> then = velocity_between(before_[contact.body_a], c.arm_a, before_[contact.body_b], c.arm_b);
      c.gap = T(c.gap + T(system_.dt) * T(c.normal.dot(u - then)));
    }
    const Vec3<T> p = unknown(next_);
    add_coulomb(contact.friction, T(1 / sizes_.mobility[i]), p, T(c.gap / T(system_.dt)), T(c.tangent_1.dot(u)),
                T(c.tangent_2.dot(u)));
    const Vec3<T> impulse = c.normal * p[0] + c.tangent_1 * p[1] + c.tangent_2 * p[2];
    const Vec3<T> no_moment = as<T>(Vector3d::Zero());
    apply_impulse(contact.body_a, c.arm_a, impulse, no_moment);
    apply_impulse(contact.body_b, c.arm_b, -impulse, no_moment);
    next_ += 3;
  }

  // (42, 43): p_n = max(0, x_n), p_f = P_D(mu max(0, x_n))(x_f), x = p - rho (closing, nu)
  void add_coulomb(double friction, const T& rho, const Vec3<T>& p, const T& closing, const T& nu_1, const T& nu_2) {
    const T x_n = T(p[0] - rho * closing), x_1 = T(p[1] - rho * nu_1), x_2 = T(p[2] - rho * nu_2);
    const double length = std::hypot(value_of(x_1), value_of(x_2));
    if (!(value_of(x_n) > 0)) {
      for (int k = 0; k < 3; ++k) f_[next_ + k] = T(p[k] / rho);
      return;
    }
    f_[next_] = closing;
    if (length <= friction * value_of(x_n)) {
      f_[next_ + 1] = nu_1;
      f_[next_ + 2] = nu_2;
    } else {
      const T share = T(T(friction) * x_n / root(T(x_1 * x_1 + x_2 * x_2)));
      f_[next_ + 1] = T(T(p[1] - share * x_1) / rho);
      f_[next_ + 2] = T(T(p[2] - share * x_2) / rho);
    }
  }

  void add_joint(std::size_t i) {
    const ImplicitJoint& joint = system_.joints[i];
    const BodyAt<T>&a = current_[joint.body_a], &b = current_[joint.body_b];
    const T dt = T(system_.dt);
    JointAt<T> j = joint_at(joint, a, b);
    const Vec3<T> u = velocity_between(a, j.arm_a, b, j.arm_b), relative_w = a.w - b.w;
    if (frozen_) {
      const BodyAt<T>&then_a = before_[joint.body_a], &then_b = before_[joint.body_b];
      const Vec3<T> du = u - velocity_between(then_a, j.arm_a, then_b, j.arm_b), dw = relative_w - then_a.w + then_b.w;
      j.error += du * dt;
      j.tilt_1 = T(j.tilt_1 + dt * T(j.across_1.dot(dw)));
      j.tilt_2 = T(j.tilt_2 + dt * T(j.across_2.dot(dw)));
    }
    f_.template segment<3>(next_) = j.error * T(1 / system_.dt);
    const Vec3<T> impulse = unknown(next_);
    Vec3<T> moment = as<T>(Vector3d::Zero());
    next_ += 3;
    if (joint.hinge) moment = add_hinge(i, j, T(j.axis.dot(relative_w)));
    apply_impulse(joint.body_a, j.arm_a, impulse, moment);
    apply_impulse(joint.body_b, j.arm_b, -impulse, -moment);
  }

  // Two axes that stay parallel, and dry friction of at most dt times `dry` against the rotation nu (44).
  Vec3<T> add_hinge(std::size_t i, const JointAt<T>& j, const T& nu) {
    const double radius = sizes_.radius[i], rho = 1 / sizes_.mobility[system_.contacts.size() + i];
    const double most = system_.dt * system_.joints[i].dry;
    const Vec3<T> p = unknown(next_);
    f_[next_] = T(j.tilt_1 * T(radius / system_.dt));
    f_[next_ + 1] = T(j.tilt_2 * T(radius / system_.dt));
    const double x = value_of(T(p[2] - T(rho) * nu));
    if (std::abs(x) <= most)
      f_[next_ + 2] = T(nu * T(radius));
    else
      f_[next_ + 2] = T(T(p[2] - T(x > 0 ? most : -most)) * T(radius / rho));
    next_ += 3;
    return j.across_1 * p[0] + j.across_2 * p[1] + j.axis * p[2];
  }

  // (39), with what has been given to the body by now
  void add_body(std::size_t i) {
    const ImplicitBody& body = system_.bodies[i];
    if (!(body.mass > 0)) return;
    const Mat3<T> half = current_[i].r * as<T>(body.inertia), inertia = half * current_[i].r.transpose();
    const Vec3<T> w = frozen_ ? before_[i].w : current_[i].w, angular_momentum = inertia * w;
    const Vec3<T> gained = inertia * (current_[i].w - as<T>(body.w)) + w.cross(angular_momentum) * T(system_.dt);
    const double angular_scale = std::sqrt(body.mass * body.inertia.diagonal().maxCoeff());
    f_.template segment<3>(next_) = current_[i].v - as<T>(body.v) - push_[i] * T(1 / body.mass);
    f_.template segment<3>(next_ + 3) = (gained - twist_[i]) * T(1 / angular_scale);
    next_ += 6;
  }

  const ImplicitSystem& system_;
  const RowSizes& sizes_;
  const Vector& y_;
  const VectorXd* frozen_;
  Vector f_;
  Index next_ = 0;
  std::vector<BodyAt<T>> current_, before_;  // before: with the velocities that led to the frozen pose
  std::vector<Vec3<T>> push_, twist_;        // impulses, and moments about the centre of mass
};

}  // namespace lockstep::oracle::models
