// The one-contact problem of slip and torsion against what shares nothing with it: the conditions that it states, and a
// search for the shift by halving with Eigen's factorisation.
#include "cpu_reference/torsion_cone.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tests/worlds.hpp"

namespace lockstep::test::torsion_cone_test {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;

struct Problem {
  Matrix4d w;  // normal, two tangents, spin
  Vector4d q;
  double mu;
};

// J M^-1 J^T of a contact between two bodies, its torsion at a radius that is small beside them.
Problem random_problem(Random& random) {
  Eigen::Matrix<double, 4, 12> j = Eigen::Matrix<double, 4, 12>::Zero();
  const double radius = random.between(0, 1) < 0.5 ? random.between(0.001, 0.05) : random.between(0.05, 1);
  Eigen::VectorXd inverse(12);
  for (int side = 0; side < 2; ++side) {
    const Vector3 offset = random.vector(1);
    const Vector3d arm(offset[0], offset[1], offset[2]);
    const double sign = side == 0 ? 1 : -1;
    j.block<3, 3>(0, 6 * side) = sign * Eigen::Matrix3d::Identity();
    for (int row = 0; row < 3; ++row) j.block<1, 3>(row, 6 * side + 3) = sign * arm.cross(Vector3d::Unit(row));
    j(3, 6 * side + 3) = sign * radius;  // the normal is x
    const double mass = random.between(0.1, 10);
    for (int k = 0; k < 3; ++k) {
      inverse[6 * side + k] = 1 / mass;
      inverse[6 * side + 3 + k] = 1 / (mass * random.between(0.1, 0.5));
    }
  }
  Problem p;
  p.w = j * inverse.asDiagonal() * j.transpose();
  p.q = {-random.between(0, 1), random.between(-1, 1), random.between(-1, 1), radius * random.between(-5, 5)};
  p.mu = random.between(0, 3);
  return p;
}

template <class real>
Vector4d solve(const Problem& p) {
  const auto w = [&](int i, int k) { return real(p.w(i, k)); };
  const reference::TorsionDelassus<real> delassus = {w(0, 0), w(1, 1), w(2, 2), w(0, 1), w(0, 2),
                                                     w(1, 2), w(3, 3), w(0, 3), w(1, 3), w(2, 3)};
  const auto r = reference::solve_torsion_cone<real>({real(p.q[0]), real(p.q[1]), real(p.q[2]), real(p.q[3])}, delassus,
                                                     real(p.mu));
  return {double(r.normal), double(r.tangent_1), double(r.tangent_2), double(r.torsion)};
}

// By halving: (A + lambda) t = -b with |t| = mu r_n; NaN where no such slip is bracketed.
Vector4d slip_by_halving(const Problem& p) {
  const Vector3d wn = p.w.block<3, 1>(1, 0);
  const Eigen::Matrix3d a = p.w.block<3, 3>(1, 1) - wn * wn.transpose() / p.w(0, 0);
  const Vector3d b = p.q.tail<3>() - wn * p.q[0] / p.w(0, 0);
  const auto at = [&](double lambda) {
    const Vector3d t = (a + lambda * Eigen::Matrix3d::Identity()).ldlt().solve(-b);
    Vector4d r;
    r << (-p.q[0] - wn.dot(t)) / p.w(0, 0), t;
    return r;
  };
  const auto excess = [&](const Vector4d& r) { return r.tail<3>().norm() - p.mu * r[0]; };
  double low = 0, high = 1;
  while (excess(at(high)) > 0 && high < 1e12) high *= 2;
  for (int i = 0; i < 200; ++i) (excess(at(0.5 * (low + high))) > 0 ? low : high) = 0.5 * (low + high);
  return at(high);
}

TEST(TorsionCone, KeepsItsLaw) {
  Random random(3);
  int slips = 0, sticks = 0;
  for (int i = 0; i < 20000; ++i) {
    const Problem p = random_problem(random);
    const Vector4d r = solve<double>(p), u = p.w * r + p.q;
    const double tangential = r.tail<3>().norm(), limit = p.mu * r[0];
    EXPECT_GE(r[0], 0);
    EXPECT_NEAR(u[0], 0, 1e-12);  // all of these approach
    EXPECT_LE(tangential, limit * (1 + 1e-12));
    if (u.tail<3>().norm() < 1e-10) {
      ++sticks;
      continue;
    }
    ++slips;
    EXPECT_NEAR(tangential, limit, 1e-12 * limit);
    // against (u_t, u_s): the part of the velocity across the impulse, and its sign
    const Vector3d e = r.tail<3>() / tangential, u_t = u.tail<3>();
    EXPECT_LT((u_t - u_t.dot(e) * e).norm(), 1e-6 * u_t.norm()) << i;
    EXPECT_LT(u_t.dot(e), 0) << i;
  }
  EXPECT_GT(sticks, 300);
  EXPECT_GT(slips, 1000);
}

TEST(TorsionCone, SlipsAsAnotherSearchFinds) {
  Random random(4);
  int compared = 0;
  double worst = 0, worst_float = 0;
  for (int i = 0; i < 20000; ++i) {
    Problem p = random_problem(random);
    if (p.mu * p.w.block<3, 1>(1, 0).norm() > 0.9 * p.w(0, 0)) continue;  // where there may be several slips
    const Vector4d r = solve<double>(p);
    if ((p.w * r + p.q).tail<3>().norm() < 1e-10) continue;
    const Vector4d expected = slip_by_halving(p);
    worst = std::max(worst, (r - expected).norm() / expected.norm());
    worst_float = std::max(worst_float, (solve<float>(p) - expected).norm() / expected.norm());
    ++compared;
  }
  EXPECT_GT(compared, 3000);
  EXPECT_LT(worst, 1e-7);
  EXPECT_LT(worst_float, 2e-3);
}

// Without torsion it is the cone of three rows.
TEST(TorsionCone, WithoutTorsionIsTheConeOfSlip) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    Problem p = random_problem(random);
    p.w.row(3).setZero();
    p.w.col(3).setZero();
    p.w(3, 3) = p.w(0, 0);
    p.q[3] = 0;
    const Vector4d r = solve<double>(p);
    const auto cone = reference::solve_general<double>(
        {p.q[0], p.q[1], p.q[2]}, {p.w(0, 0), p.w(1, 1), p.w(2, 2), p.w(0, 1), p.w(0, 2), p.w(1, 2)}, p.mu);
    EXPECT_EQ(r[3], 0);
    EXPECT_NEAR(r[0], cone.normal, 1e-9 * cone.normal);
    EXPECT_NEAR(r[1], cone.tangent_1, 1e-7 * cone.normal);
    EXPECT_NEAR(r[2], cone.tangent_2, 1e-7 * cone.normal);
  }
}

TEST(TorsionCone, TakesOff) {
  Problem p;
  p.w = Matrix4d::Identity();
  p.q = {0, 1, 1, 1};
  p.mu = 1;
  EXPECT_EQ(solve<double>(p), Vector4d(Vector4d::Zero()));
}

// Friction without a limit and none at all.
TEST(TorsionCone, IsExactWithoutFriction) {
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    Problem p = random_problem(random);
    p.mu = 0;
    const Vector4d r = solve<double>(p);
    EXPECT_NEAR(r[0], -p.q[0] / p.w(0, 0), 1e-12);
    EXPECT_EQ(r.tail<3>().norm(), 0);
  }
}

}  // namespace
}  // namespace lockstep::test::torsion_cone_test
