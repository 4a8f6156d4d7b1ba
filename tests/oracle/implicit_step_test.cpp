// Model-mNCP against closed forms, and against the linearised step: what being implicit is good for.
#include "cpu_reference/oracle/models/implicit_step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace lockstep::oracle::models::implicit_step_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;

constexpr double g = 9.81;
constexpr SolveLimits tight = {.tolerance = 3e-12, .iterations = 60};

using Solve = SolveReport (*)(const ImplicitSystem&, const SolveLimits&, VectorXd&);

ImplicitBody ball(double mass, double radius, const Vector3d& x, const Vector3d& v = Vector3d::Zero()) {
  ImplicitBody body;
  body.mass = mass;
  body.inertia = 0.4 * mass * radius * radius * Matrix3d::Identity();
  body.x = x;
  body.v = v;
  body.force = -mass * g * Vector3d::UnitZ();
  return body;
}

/// A ball of radius 0.1 in a bowl of radius 1 about the origin, `angle` from the lowest point.
ImplicitSystem ball_in_bowl(double angle, const Vector3d& v, double friction, double dt) {
  ImplicitSystem system;
  system.dt = dt;
  system.bodies = {ImplicitBody(), ball(2, 0.1, 0.9 * Vector3d(std::sin(angle), 0, -std::cos(angle)), v)};
  system.contacts.push_back(
      {.body_a = 1, .body_b = 0, .radius_a = 0.1, .surface = Surface::bowl, .radius_b = 1, .friction = friction});
  return system;
}

/// A rod of length 1 on a pivot, `angle` from hanging.
ImplicitSystem pendulum(double angle, double dt) {
  ImplicitSystem system;
  system.dt = dt;
  ImplicitBody rod;
  rod.mass = 1;
  rod.inertia = Vector3d(1.0 / 12, 1.0 / 12, 1e-3).asDiagonal();
  rod.x = 0.5 * Vector3d(std::sin(angle), 0, -std::cos(angle));
  rod.q = Eigen::AngleAxisd(-angle, Vector3d::UnitY());
  rod.force = -g * Vector3d::UnitZ();
  system.bodies = {ImplicitBody(), rod};
  system.joints.push_back({.body_a = 1, .body_b = 0, .anchor_a = {0, 0, 0.5}});
  return system;
}

ImplicitSystem stepped(ImplicitSystem system, Solve solve, int steps) {
  VectorXd y;
  for (int i = 0; i < steps; ++i) {
    const SolveReport report = solve(system, tight, y);
    EXPECT_EQ(report.stop, Stop::solved) << "step " << i << ": " << report.residual;
    system = moved(system, y);
  }
  return system;
}

// theta'' = -rate sin theta from rest, by Runge-Kutta 4 in steps so small that their error does not count.
double swing(double theta, double rate, double seconds) {
  constexpr int steps = 20000;
  const double h = seconds / steps;
  double speed = 0;
  for (int i = 0; i < steps; ++i) {
    const auto a = [&](double x) { return -rate * std::sin(x); };
    const double k1 = speed, l1 = a(theta), k2 = speed + h / 2 * l1, l2 = a(theta + h / 2 * k1);
    const double k3 = speed + h / 2 * l2, l3 = a(theta + h / 2 * k2), k4 = speed + h * l3, l4 = a(theta + h * k3);
    theta += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    speed += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
  }
  return theta;
}

double angle_of(const ImplicitBody& body) { return std::atan2(body.x.x(), -body.x.z()); }

// Of a ball of radius 0.1 on the bowl, in the tangent plane. Along the normal it has the velocity of a chord.
Vector3d slip_of(const ImplicitBody& b) {
  const Vector3d out = b.x.normalized(), u = b.v + b.w.cross(0.1 * out);
  return u - out.dot(u) * out;
}

// Without friction a ball in a bowl is pushed along the normal of where it ends: x' = y + n' p dt / m. So x' is the
// point of the sphere of centres that is nearest to the free motion's y, and where y is within it, y itself.
TEST(ImplicitStep, OfABallInABowlIsTheNearestPoint) {
  for (const Solve solve : {implicit_newton, implicit_fixed_point}) {
    for (const Vector3d& v : {Vector3d(3, 1, 0), Vector3d(-2, 0, -4), Vector3d(0, 0, 3)}) {
      const ImplicitSystem start = ball_in_bowl(0.7, v, 0, 0.05);
      const Vector3d free = start.bodies[1].x + 0.05 * (v - 0.05 * g * Vector3d::UnitZ());
      const Vector3d exact = free.norm() > 0.9 ? Vector3d(0.9 * free.normalized()) : free;
      VectorXd y;
      EXPECT_EQ(solve(start, tight, y).stop, Stop::solved);
      EXPECT_LT((moved(start, y).bodies[1].x - exact).norm(), 1e-12);
      EXPECT_NEAR(y[6], free.norm() > 0.9 ? 2 / 0.05 * (free.norm() - 0.9) : 0, 1e-10) << "normal impulse";
    }
  }
}

// The linearised step meets the plane tangent to the bowl where it starts: off by s^2 / 2 R after a way of s.
TEST(ImplicitStep, LinearisedLeavesTheSurfaceBySecondOrder) {
  double before = 0;
  for (const double dt : {0.02, 0.01, 0.005}) {
    const ImplicitSystem start = ball_in_bowl(0, Vector3d(2, 0, 0), 0, dt);
    const double linear = gap(stepped(start, linearised_step, 1), 0), travel = 2 * dt;
    EXPECT_NEAR(linear, 0.9 - std::hypot(0.9, travel), 1e-12) << dt;
    EXPECT_NEAR(gap(stepped(start, implicit_newton, 1), 0), 0, 1e-12) << dt;
    if (before != 0) {
      EXPECT_NEAR(std::log2(before / linear), 2, 0.01);
    }
    before = linear;
  }
}

// A pendulum: both steps are of first order in time, and only the implicit one stays on its pivot.
TEST(ImplicitStep, OfAPendulumKeepsThePivot) {
  const double exact = swing(1, 1.5 * g, 0.5);
  double implicit_before = 0, linear_before = 0, open_before = 0;
  for (const int steps : {50, 100, 200}) {
    const ImplicitSystem start = pendulum(1, 0.5 / steps);
    const ImplicitSystem implicit = stepped(start, implicit_newton, steps),
                         linear = stepped(start, linearised_step, steps);
    const double implicit_error = std::abs(angle_of(implicit.bodies[1]) - exact);
    const double linear_error = std::abs(angle_of(linear.bodies[1]) - exact), open = joint_error(linear, 0);
    EXPECT_LT(joint_error(implicit, 0), 1e-12) << steps;
    EXPECT_GT(open, 1e-6) << steps;
    if (open_before > 0) {
      EXPECT_NEAR(std::log2(implicit_before / implicit_error), 1, 0.1) << steps;
      EXPECT_NEAR(std::log2(linear_before / linear_error), 1, 0.15) << steps;
      EXPECT_NEAR(std::log2(open_before / open), 2, 0.2) << steps;
    }
    implicit_before = implicit_error;
    linear_before = linear_error;
    open_before = open;
  }
}

// A ball that rolls in a bowl swings like a pendulum of 7/5 the length: (R - r) theta'' = -5/7 g sin theta.
TEST(ImplicitStep, OfARollingBallConvergesByFirstOrder) {
  const double exact = swing(0.5, 5.0 / 7 * g / 0.9, 0.4);
  double before = 0;
  for (const int steps : {40, 80, 160}) {
    const ImplicitSystem end = stepped(ball_in_bowl(0.5, Vector3d::Zero(), 1, 0.4 / steps), implicit_newton, steps);
    const ImplicitBody& b = end.bodies[1];
    EXPECT_LT(slip_of(b).norm(), 1e-10) << "rolls";
    EXPECT_LT(std::abs(gap(end, 0)), 1e-12);
    const double error = std::abs(angle_of(b) - exact);
    if (before > 0) {
      EXPECT_NEAR(std::log2(before / error), 1, 0.1) << steps;
    }
    before = error;
  }
}

// Too smooth to roll, and thrown across: friction is mu p_n against the slip of the step's end.
TEST(ImplicitStep, FrictionIsAgainstTheSlipAtTheEnd) {
  const ImplicitSystem start = ball_in_bowl(0.3, Vector3d(1, 2, 0), 0.1, 0.02);
  VectorXd newton, fixed;
  ASSERT_EQ(implicit_newton(start, tight, newton).stop, Stop::solved);
  ASSERT_EQ(implicit_fixed_point(start, tight, fixed).stop, Stop::solved);
  EXPECT_LT((newton - fixed).norm(), 1e-9);
  const ImplicitBody b = moved(start, newton).bodies[1];
  const Vector3d normal = -b.x.normalized(), slip = slip_of(b);
  const Vector3d impulse = 2 * (b.v - start.bodies[1].v + 0.02 * g * Vector3d::UnitZ());
  const double pressed = impulse.dot(normal);
  EXPECT_GT(pressed, 0);
  EXPECT_GT(slip.norm(), 0.5);
  EXPECT_LT((impulse - pressed * normal + 0.1 * pressed * slip.normalized()).norm(), 1e-10);
}

// Newton's error is squared from step to step; the fixed point's shrinks by a factor of the order of dt^2.
TEST(ImplicitStep, NewtonIsQuadraticAndTheFixedPointLinear) {
  std::vector<double> factors;
  for (const double dt : {0.04, 0.02, 0.01}) {
    const ImplicitSystem start = ball_in_bowl(0.8, Vector3d(3, 1, 2), 0.2, dt);
    VectorXd y;
    const SolveReport newton = implicit_newton(start, tight, y);
    y.resize(0);
    const SolveReport fixed = implicit_fixed_point(start, tight, y);
    EXPECT_LE(newton.iterations, 6u);
    EXPECT_GE(newton.residuals.size(), 3u);
    ASSERT_GE(fixed.residuals.size(), 3u);
    factors.push_back(fixed.residuals[1] / fixed.residuals[0]);
    const auto& r = newton.residuals;
    for (std::size_t i = 2; i + 1 < r.size(); ++i) EXPECT_LE(r[i], 20 * r[i - 1] * r[i - 1] + 1e-14) << i;
  }
  EXPECT_LT(factors[0], 0.5);
  EXPECT_GT(std::log2(factors[0] / factors[1]), 0.9);
  EXPECT_GT(std::log2(factors[1] / factors[2]), 0.9);
}

// A wheel with dry friction in its hinge loses dry dt / I, and stands.
TEST(ImplicitStep, HingesHaveDryFriction) {
  ImplicitSystem system;
  system.dt = 0.1;
  ImplicitBody wheel;
  wheel.mass = 3;
  wheel.inertia = Vector3d(0.3, 0.3, 0.5).asDiagonal();
  wheel.w = {0, 0, 2};
  wheel.force = -3 * g * Vector3d::UnitZ();
  system.bodies = {ImplicitBody(), wheel};
  system.joints.push_back({.body_a = 1, .body_b = 0, .hinge = true, .dry = 3});
  for (const Solve solve : {implicit_newton, implicit_fixed_point}) {
    VectorXd y;
    ASSERT_EQ(solve(system, tight, y).stop, Stop::solved);
    EXPECT_NEAR(y[5], 2 - 3 * 0.1 / 0.5, 1e-13);
    EXPECT_NEAR(y[11], -0.3, 1e-13) << "all that the hinge has";
    EXPECT_LT(y.head<5>().norm(), 1e-12) << "hangs";
    const ImplicitSystem end = stepped(system, solve, 4);
    EXPECT_NEAR(end.bodies[1].w.norm(), 0, 1e-12);
    EXPECT_NEAR(Eigen::AngleAxisd(end.bodies[1].q).angle(), 0.1 * (1.4 + 0.8 + 0.2), 0.02);
  }
}

// Hinges keep their axes while the body swings, tips and spins about them.
TEST(ImplicitStep, HingesKeepTheirAxes) {
  ImplicitSystem system = pendulum(1, 0.01);
  system.joints[0].hinge = true;
  system.joints[0].axis_a = system.joints[0].axis_b = Vector3d::UnitY();
  system.bodies[1].torque = {0.5, 0, 0.5};
  const ImplicitSystem end = stepped(system, implicit_newton, 30);
  EXPECT_LT((end.bodies[1].q * Vector3d::UnitY() - Vector3d::UnitY()).norm(), 1e-11);
  EXPECT_LT(joint_error(end, 0), 1e-12);
  EXPECT_GT(std::abs(angle_of(end.bodies[1]) - 1), 0.1);
}

// The kinematic map of (40): Q' - Q = dt/2 (0, w') Q' is what the step does, up to the length of Q'.
TEST(ImplicitStep, RotatesByTheImplicitKinematicMap) {
  ImplicitSystem system;
  system.dt = 0.2;
  ImplicitBody body;
  body.mass = 1;
  body.inertia = Vector3d(1, 2, 3).asDiagonal();
  body.q = Quaterniond(0.5, -0.1, 0.7, 0.3).normalized();
  body.w = {1, -3, 2};
  system.bodies = {body};
  VectorXd y;
  ASSERT_EQ(implicit_newton(system, tight, y).stop, Stop::solved);
  const Quaterniond q = moved(system, y).bodies[0].q;
  const Vector3d w = y.segment<3>(3);
  const Quaterniond product = Quaterniond(0, w.x(), w.y(), w.z()) * q;
  const Eigen::Vector4d rest = q.coeffs() - 0.1 * product.coeffs();  // parallel to the old one
  EXPECT_LT((rest.normalized() - body.q.coeffs()).norm(), 1e-14);
  // I' (w' - w) + dt w' x I' w' = 0 (39)
  const Matrix3d r = q.toRotationMatrix(), inertia = r * body.inertia * r.transpose();
  EXPECT_LT((inertia * (w - body.w) + 0.2 * w.cross(inertia * w)).norm(), 1e-12);
}

TEST(ImplicitStep, TellsWhereItDidNotGetThere) {
  VectorXd y;
  const SolveReport report =
      implicit_newton(ball_in_bowl(0.8, Vector3d(3, 1, 2), 0.3, 0.04), {.tolerance = 1e-12, .iterations = 1}, y);
  EXPECT_EQ(report.stop, Stop::limit);
  EXPECT_GT(report.residual, 1e-12);
}

}  // namespace
}  // namespace lockstep::oracle::models::implicit_step_test
