// The problem of one contact, solved in three ways, against closed forms and against each other.
#include "cpu_reference/oracle/cone/local_cone.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "cpu_reference/oracle/cone/cone.hpp"

namespace lockstep::oracle::local_cone_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Case {
  Matrix3d w;
  Vector3d q;
  double mu;
};

// A block of a contact: of full rank or less, well-conditioned or not, with weak or strong coupling.
Case random_case(std::mt19937& random) {
  const auto number = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967295.0; };
  const auto vector = [&] { return Vector3d(number(-1, 1), number(-1, 1), number(-1, 1)); };
  Case c;
  const Matrix3d j = (Matrix3d() << vector(), vector(), vector()).finished();
  Vector3d masses(1, std::pow(10, number(-6, 0)), std::pow(10, number(-6, 0)));
  c.w = std::pow(10, number(-5, 5)) * (j * masses.asDiagonal() * j.transpose());
  c.q = std::pow(10, number(-4, 2)) * vector();
  c.mu = random() % 8 == 0 ? 0 : std::pow(10, number(-2, 1));
  return c;
}

// Defect velocity over the velocities that are added up in it.
double defect(const Case& c, const Vector3d& r) {
  const double mobility = c.w.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
  return mobility * natural_map(r, c.w * r + c.q, c.mu, 1 / mobility).norm() / (c.q.norm() + mobility * r.norm());
}

TEST(LocalCone, SolvesRandomContactsExactly) {
  std::mt19937 random(1);
  double worst = 0, worst_enumerated = 0;
  int open = 0, stick = 0, slip = 0;
  for (int i = 0; i < 20000; ++i) {
    const Case c = random_case(random);
    const LocalCone cone(c.w, c.mu);
    const Vector3d r = cone.solve(c.q);
    ASSERT_TRUE(r.allFinite());
    worst = std::max(worst, defect(c, r));
    worst_enumerated = std::max(worst_enumerated, defect(c, cone.enumerate(c.q)));
    const double t = r.tail<2>().norm();
    ++(r[0] == 0 ? open : t < c.mu * r[0] * (1 - 1e-12) ? stick : slip);
  }
  EXPECT_LT(worst, 1e-14);
  EXPECT_LT(worst_enumerated, 1e-12);
  EXPECT_GT(std::min({open, stick, slip}), 1000);
}

TEST(LocalCone, SplittingConvergesInAFewIterations) {
  std::mt19937 random(2);
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    Case c = random_case(random);
    c.w += 0.3 * c.w.trace() * Matrix3d::Identity();  // splitting is slow for what is ill-conditioned
    c.mu = std::min(c.mu, 0.8);
    const LocalCone cone(c.w, c.mu);
    Vector3d r = Vector3d::Zero();
    for (int iteration = 0; iteration < 20; ++iteration) r = cone.split(c.q, r);
    worst = std::max(worst, defect(c, r));
  }
  EXPECT_LT(worst, 1e-9);
}

TEST(LocalCone, SlidesAgainstTheVelocityThatIsLeft) {
  Matrix3d w;
  w << 2, 0.3, -0.1, 0.3, 3, 0.2, -0.1, 0.2, 1;
  const Vector3d q(-1, 5, 2);
  const Vector3d r = LocalCone(w, 0.4).solve(q), u = w * r + q;
  EXPECT_NEAR(u[0], 0, 1e-14);
  EXPECT_NEAR(r.tail<2>().norm(), 0.4 * r[0], 1e-15);
  EXPECT_NEAR(r.tail<2>().dot(u.tail<2>()), -r.tail<2>().norm() * u.tail<2>().norm(), 1e-13);
}

// A contact that cannot be moved in some direction, or in none.
TEST(LocalCone, TakesBlocksOfAnyRank) {
  for (const Vector3d& masses : {Vector3d(2, 0, 0), Vector3d(2, 3, 0), Vector3d(0, 0, 0), Vector3d(2, 0, 1)}) {
    const Matrix3d w = masses.asDiagonal();
    for (const double mu : {0.0, 0.5}) {
      const LocalCone cone(w, mu);
      const Vector3d q = w * Vector3d(-1, 2, 0.1);
      for (const Vector3d& r : {cone.solve(q), cone.enumerate(q)}) {
        ASSERT_TRUE(r.allFinite());
        EXPECT_LT(natural_map(r, w * r + q, mu, 0.3).norm(), 1e-12) << masses.transpose() << ", " << mu;
      }
    }
  }
}

// Joints that hold a body in all directions but one leave blocks of rank one, and rounding.
TEST(LocalCone, TakesWhatRoundingLeavesOfRankOne) {
  std::mt19937 random(2);
  const auto number = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967295.0; };
  for (int i = 0; i < 20000; ++i) {
    const Vector3d d(number(0.5, 1), number(-1, 1), number(-1, 1));
    Case c = {d * d.transpose(), -number(0.01, 10) * d, number(0.1, 1)};
    const double mobility = d.squaredNorm(), speed = c.q.norm();
    for (double& of : c.w.reshaped()) of += number(-1e-14, 1e-14) * mobility;
    for (double& of : c.q) of += number(-1e-14, 1e-14) * speed;
    c.w = 0.5 * (c.w + c.w.transpose().eval());
    const Vector3d r = LocalCone(c.w, c.mu).solve(c.q);
    ASSERT_TRUE(r.allFinite()) << i;
    EXPECT_LT(defect(c, r), 1e-11) << i;
  }
}

}  // namespace
}  // namespace lockstep::oracle::local_cone_test
