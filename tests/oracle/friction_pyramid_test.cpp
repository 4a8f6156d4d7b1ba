// Model-mLCP and Model-LCP against answers in closed form: what a pyramid of n_d sides makes of Coulomb's cone.
#include "cpu_reference/oracle/models/friction_pyramid.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <string>

#include "host/error.hpp"
#include "tests/oracle/lcp_problems.hpp"
#include "tests/oracle/multibodies.hpp"

namespace lockstep::oracle::models::friction_pyramid_test {
namespace {

using lcp::test::solve;
using std::numbers::pi;
using test::g;

constexpr double mu = 0.5, dt = 0.01;
constexpr SolveLimits tight = {.tolerance = 1e-12};

VectorXd velocities_of(const Multibody& m, int directions) {
  const FrictionPyramid pyramid(m, directions);
  const auto solved = solve(lcp::lemke, pyramid.reduced(), tight);
  EXPECT_EQ(solved.report.stop, Stop::solved);
  return pyramid.velocities(solved.z);
}

// How far the velocity after a step is from the exact one, in parts of what friction takes, mu g dt.
double error_of_sliding(double angle, int directions) {
  const double speed = 1, left = speed - mu * g * dt;
  const VectorXd u = velocities_of(test::sliding_point(speed, angle, mu, dt), directions);
  const Vector3d exact = left * Vector3d(std::cos(angle), std::sin(angle), 0);
  EXPECT_NEAR(u[8], 0, 1e-12);
  return (u.segment<3>(6) - exact).norm() / (mu * g * dt);
}

TEST(FrictionPyramid, IsExactAlongItsDirections) {
  for (const int directions : {3, 4, 7, 8, 16}) {
    for (int j = 0; j < directions; ++j) {
      const double angle = pi + 2 * pi * j / directions;  // friction is along d_j
      EXPECT_LT(error_of_sliding(angle, directions), 1e-10) << directions << ", " << j;
    }
  }
}

// At worst sliding is half way between two directions... nearly: friction is then along one of them, pi / n_d off, an
// error of 2 sin(pi / (2 n_d)): first order. Exactly half way it is between them, mu cos(pi / n_d): second order.
TEST(FrictionPyramid, ConvergesToTheCone) {
  double before = 0, before_between = 0;
  for (const int directions : {4, 8, 16, 32, 64}) {
    double worst = 0;
    for (int k = 0; k < 50; ++k) worst = std::max(worst, error_of_sliding(2 * pi * (k + 0.37) / 50 / 4, directions));
    const double between = error_of_sliding(pi + pi / directions, directions);
    EXPECT_LE(worst, 2 * std::sin(pi / (2 * directions)) + 1e-10) << directions;
    EXPECT_NEAR(between, 1 - std::cos(pi / directions), 1e-10) << directions;
    if (before > 0) {
      EXPECT_NEAR(std::log2(before / worst), 1, 0.25) << directions;
      EXPECT_NEAR(std::log2(before_between / between), 2, 0.1) << directions;
    }
    before = worst;
    before_between = between;
  }
}

// A ball slides on the ground until it rolls, with 5/7 of its speed, after 2 v / (7 mu g): along x with any pyramid.
// Along the diagonal the pyramid of four sides rubs cos 45 degrees as much, and the ball takes 1.41 times as long; with
// eight sides the diagonal is one of its directions.
TEST(FrictionPyramid, FourSidesMissDiagonalRolling) {
  const double step = 1e-3, speed = 1, friction = 0.2;
  const auto time_to_roll = [&](double angle, int directions) {
    const Vector3d along(std::cos(angle), std::sin(angle), 0);
    Vector3d v = speed * along, w = Vector3d::Zero();
    for (int k = 1; k < 2000; ++k) {
      const VectorXd u = velocities_of(test::ball_on_ground(v, w, friction, step), directions);
      v = u.segment<3>(6);
      w = u.segment<3>(9);
      const Vector3d slip = v + w.cross(Vector3d(0, 0, -0.5));
      if (slip.norm() < 1e-9) {
        EXPECT_LT((v - 5.0 / 7 * speed * along).norm(), 1e-9);
        return k * step;
      }
    }
    return 0.0;
  };
  const double exact = 2 * speed / (7 * friction * g);
  EXPECT_NEAR(time_to_roll(0, 4), exact, step);
  EXPECT_NEAR(time_to_roll(pi / 4, 4), std::sqrt(2.0) * exact, step);
  EXPECT_NEAR(time_to_roll(pi / 4, 8), exact, step);
}

// A push holds up to mu m g along a direction, to mu m g cos(pi / n_d) between two.
TEST(FrictionPyramid, SticksWithinThePolygon) {
  for (const int directions : {4, 8, 16}) {
    for (const bool between : {false, true}) {
      const double angle = pi + (between ? pi / directions : 0), limit = between ? std::cos(pi / directions) : 1;
      const auto after = [&](double share) {
        return velocities_of(test::sliding_point(share * mu * g * dt, angle, mu, dt), directions).segment<3>(6).norm();
      };
      EXPECT_LT(after(0.999 * limit), 1e-12) << directions << between;
      EXPECT_NEAR(after(1.001 * limit), 0.001 * limit * mu * g * dt, 1e-12) << directions << between;
    }
  }
}

TEST(FrictionPyramid, WithoutFrictionIsWithoutFriction) {
  const Multibody m = test::sliding_point(1, 0.3, 0, dt);
  const VectorXd u = velocities_of(m, 4);
  EXPECT_NEAR(u[6], std::cos(0.3), 1e-14);
  EXPECT_NEAR(u[8], 0, 1e-14);
}

TEST(FrictionPyramid, OfNothingIsNothing) {
  const Multibody none;
  EXPECT_EQ(FrictionPyramid(none, 4).reduced().size(), 0);
  EXPECT_EQ(FrictionPyramid(none, 4).mixed().stacked().size(), 0);
  EXPECT_THROW(FrictionPyramid(none, 2), Error);
}

// LCP(A, b) with A = F - B D^-1 C and b = a - B D^-1 r (definition 8).
TEST(FrictionPyramid, ReducedIsTheMixedOneWithoutItsEqualities) {
  const Multibody m = test::hinged_bar(0.4, 0.3);
  for (const int directions : {4, 6}) {
    const FrictionPyramid pyramid(m, directions);
    const MixedLcp mixed = pyramid.mixed();
    const lcp::Lcp reduced = pyramid.reduced();
    const Eigen::FullPivLU<MatrixXd> d(mixed.d);
    ASSERT_TRUE(d.isInvertible());
    EXPECT_LT((reduced.m - (mixed.f - mixed.b * d.solve(mixed.c))).norm(), 1e-11 * reduced.m.norm());
    EXPECT_LT((reduced.q - (mixed.a - mixed.b * d.solve(mixed.r))).norm(), 1e-11 * reduced.q.norm());

    // a solution of the mixed problem, without its w, solves the reduced one, and w has its velocities
    VectorXd z;
    const SolveReport newton = lcp::fischer_newton(mixed.stacked(), tight, z);
    ASSERT_EQ(newton.stop, Stop::solved);
    const VectorXd x = z.head(pyramid.size()), u = pyramid.velocities(x);
    EXPECT_LT(lcp::residual(reduced, x), 1e-10);
    EXPECT_LT((z.segment(pyramid.size(), 12) - u.tail(12)).norm(), 1e-9) << "velocities of the two halves";
    for (const BilateralRow& row : m.joint_rows) {
      const Vector3d v = u.segment<3>(6) - u.segment<3>(12);
      EXPECT_NEAR(
          row.row.linear.dot(v) + row.row.angular_a.dot(u.segment<3>(9)) + row.row.angular_b.dot(u.segment<3>(15)), 0,
          1e-12);
    }
  }
}

// With friction even the velocities are not unique: two solutions of one problem.
TEST(FrictionPyramid, HasMoreThanOneSolution) {
  const Multibody m = test::hinged_bar(0.4, 0.3);
  const FrictionPyramid pyramid(m, 4);
  const lcp::Lcp p = pyramid.reduced();
  const auto one = solve(lcp::lemke, p, tight);
  VectorXd z;
  ASSERT_EQ(lcp::fischer_newton(pyramid.mixed().stacked(), tight, z).stop, Stop::solved);
  const VectorXd other = z.head(pyramid.size());
  EXPECT_LT(lcp::residual(p, one.z), 1e-10);
  EXPECT_LT(lcp::residual(p, other), 1e-10);
  EXPECT_GT((pyramid.velocities(one.z) - pyramid.velocities(other)).norm(), 1e-3);
}

// A joint said twice: D is singular, its impulses are not unique; what acts at the contacts solves the problem of the
// joint said once.
TEST(FrictionPyramid, LoopsAreRefusedByTheReducedModelOnly) {
  const Multibody once = test::hinged_bar(0.4, 0.3);
  Multibody twice = once;
  twice.joint_rows.insert(twice.joint_rows.end(), once.joint_rows.begin(), once.joint_rows.end());
  try {
    FrictionPyramid(twice, 4).reduced();
    ADD_FAILURE() << "not refused";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("10 rows have rank 5: a closed loop"), std::string::npos) << e.what();
  }
  const FrictionPyramid pyramid(twice, 4);
  VectorXd z;
  const SolveReport newton = lcp::fischer_newton(pyramid.mixed().stacked(), {.tolerance = 1e-10}, z);
  ASSERT_EQ(newton.stop, Stop::solved);
  const FrictionPyramid plain(once, 4);
  const VectorXd x = z.head(pyramid.size());
  EXPECT_LT(lcp::residual(plain.reduced(), x), 1e-8);
  EXPECT_LT((z.segment(pyramid.size(), 12) - plain.velocities(x).tail(12)).norm(), 1e-8);
}

// A wheel of 0.1 kg m^2 on an axle whose dry friction takes `limit` N m s: it slows down, or stands.
TEST(FrictionPyramid, JointsHaveDryFriction) {
  Multibody m;
  m.bodies.resize(2);
  m.bodies[1] = {1, 10 * Eigen::Matrix3d::Identity(), Vector3d::Zero(), {0, 0, 2}};
  for (int i = 0; i < 3; ++i) m.joint_rows.push_back({test::ball_row(1, 0, Vector3d::Zero(), Vector3d::Zero(), i), 0});
  m.dry_rows.push_back({test::angular_row(1, 0, Vector3d::UnitZ()), 0.05});
  EXPECT_NEAR(velocities_of(m, 4)[11], 1.5, 1e-12);
  m.bodies[1].w[2] = -2;
  EXPECT_NEAR(velocities_of(m, 4)[11], -1.5, 1e-12);
  m.dry_rows[0].limit = 0.3;
  EXPECT_NEAR(velocities_of(m, 4)[11], 0, 1e-12);
  m.dry_rows[0].limit = 0;
  EXPECT_NEAR(velocities_of(m, 4)[11], -2, 1e-12);
}

// The same bar in grams and millimetres: the same velocities, in the other unit.
TEST(FrictionPyramid, DoesNotDependOnUnits) {
  const Multibody m = test::hinged_bar(0.4, 0.3);
  Multibody other = m;
  const double mass = 1e3, length = 1e3;
  for (Body& b : other.bodies) {
    b.inverse_mass /= mass;
    b.inverse_inertia /= mass * length * length;
    b.v *= length;
  }
  for (Contact& c : other.contacts) {
    c.arm_a *= length;
    c.bias *= length;
  }
  for (BilateralRow& r : other.joint_rows) {
    if (r.row.linear.isZero()) continue;
    r.row.angular_a *= length;
    r.row.angular_b *= length;
  }
  other.dry_rows[0].limit *= mass * length * length;
  const VectorXd u = velocities_of(m, 8), scaled = velocities_of(other, 8);
  for (const Index body : {6, 12}) {
    EXPECT_LT((scaled.segment<3>(body) / length - u.segment<3>(body)).norm(), 1e-11);
    EXPECT_LT((scaled.segment<3>(body + 3) - u.segment<3>(body + 3)).norm(), 1e-11);
  }
  const VectorXd wrong = VectorXd::Zero(FrictionPyramid(m, 8).size());
  EXPECT_EQ(lcp::residual(FrictionPyramid(m, 8).reduced(), wrong), 1);
}

}  // namespace
}  // namespace lockstep::oracle::models::friction_pyramid_test
