// The one-contact friction problem against an oracle that shares nothing with it: a scan of all directions of slip.
#include "cpu_reference/cone.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/worlds.hpp"

namespace lockstep::test::cone_test {
namespace {

using reference::ConeVector;
using reference::Delassus;

struct Problem {
  ConeVector<double> q;
  Delassus<double> w;
  double mu;
};

ConeVector<double> velocity(const Problem& p, const ConeVector<double>& r) {
  const auto& w = p.w;
  return {w.nn * r.normal + w.n1 * r.tangent_1 + w.n2 * r.tangent_2 + p.q.normal,
          w.n1 * r.normal + w.t11 * r.tangent_1 + w.t12 * r.tangent_2 + p.q.tangent_1,
          w.n2 * r.normal + w.t12 * r.tangent_1 + w.t22 * r.tangent_2 + p.q.tangent_2};
}

// J M^-1 J^T of a contact between bricks with points on their surfaces; one of three against an immovable body.
Delassus<double> random_delassus(Random& random) {
  double w[3][3] = {};
  const Vector3 sides[2] = {random.vector(1), random.vector(1)};
  const auto cross = [](const Vector3& a, const Vector3& b) -> Vector3 {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto unit = [](Vector3 a) {
    const double length = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    for (double& x : a) x /= length;
    return a;
  };
  for (int side = 0; side < (random.bits() % 3 == 0 ? 1 : 2); ++side) {
    const double mass = random.between(0.1, 10);
    const Vector3 half = {random.between(0.05, 1), random.between(0.05, 1), random.between(0.05, 1)};
    const Vector3 n = unit(sides[0]);
    const Vector3 t1 = unit(cross(n, sides[1])), t2 = cross(n, t1);
    Vector3 arm = {};
    for (int k = 0; k < 3; ++k) arm[k] = half[k] * random.between(-1, 1);
    const int face = int(random.bits() % 3);
    arm[face] = half[face];
    const Vector3 moments[3] = {cross(arm, n), cross(arm, t1), cross(arm, t2)};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        w[i][j] += i == j ? 1 / mass : 0;
        for (int k = 0; k < 3; ++k) {
          const double inertia =
              mass / 3 * (half[(k + 1) % 3] * half[(k + 1) % 3] + half[(k + 2) % 3] * half[(k + 2) % 3]);
          w[i][j] += moments[i][k] * moments[j][k] / inertia;
        }
      }
    }
  }
  return {w[0][0], w[1][1], w[2][2], w[0][1], w[0][2], w[1][2]};
}

Problem random_problem(Random& random) {
  return {{-random.between(0, 1), random.between(-1, 1), random.between(-1, 1)},
          random_delassus(random),
          random.between(0, 2)};
}

// All slips: impulses on the cone with u_n = 0 and u_t against r_t. The component of u_t across r_t changes its sign
// there.
std::vector<ConeVector<double>> slips(const Problem& p) {
  const auto impulse = [&](double angle) -> ConeVector<double> {
    const double c = std::cos(angle), s = std::sin(angle);
    const double normal = -p.q.normal / (p.w.nn + p.mu * (p.w.n1 * c + p.w.n2 * s));
    return {normal, p.mu * normal * c, p.mu * normal * s};
  };
  const auto across = [&](double angle) {
    const auto u = velocity(p, impulse(angle));
    return u.tangent_1 * std::sin(angle) - u.tangent_2 * std::cos(angle);
  };
  const int directions = 3600;
  const double two_pi = 2 * 3.141592653589793;
  std::vector<ConeVector<double>> found;
  for (int i = 0; i < directions; ++i) {
    double low = two_pi * i / directions, high = two_pi * (i + 1) / directions;
    if (across(low) * across(high) > 0) continue;
    const double sign = across(low);
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      (across(middle) * sign > 0 ? low : high) = middle;
    }
    const auto r = impulse(low);
    const auto u = velocity(p, r);
    if (r.normal >= 0 && u.tangent_1 * r.tangent_1 + u.tangent_2 * r.tangent_2 <= 0) found.push_back(r);
  }
  return found;
}

double distance(const ConeVector<double>& a, const ConeVector<double>& b) {
  return std::hypot(a.normal - b.normal, a.tangent_1 - b.tangent_1, a.tangent_2 - b.tangent_2);
}

double size(const ConeVector<double>& a) { return std::hypot(a.normal, a.tangent_1, a.tangent_2); }

template <class real>
ConeVector<double> solve(const Problem& p) {
  const auto r = reference::solve_general<real>(
      {real(p.q.normal), real(p.q.tangent_1), real(p.q.tangent_2)},
      {real(p.w.nn), real(p.w.t11), real(p.w.t22), real(p.w.n1), real(p.w.n2), real(p.w.t12)}, real(p.mu));
  return {double(r.normal), double(r.tangent_1), double(r.tangent_2)};
}

template <class real>
class Cone : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Cone, Precisions);

// Near to rounding, times what the problem amplifies: errors of the data in float reach the impulse through W^-1.
template <class real>
constexpr double tolerance = sizeof(real) == 4 ? 1e-4 : 1e-10;

TYPED_TEST(Cone, SolvesStickAndSlipAsTheScanDoes) {
  using real = TypeParam;
  Random random(11);
  int stuck = 0, slipped = 0;
  for (int i = 0; i < 2000; ++i) {
    const Problem p = random_problem(random);
    const ConeVector<double> r = solve<real>(p);
    const double tangent = std::hypot(r.tangent_1, r.tangent_2);
    EXPECT_LE(tangent, p.mu * r.normal * (1 + tolerance<real>));
    if (tangent < p.mu * r.normal * (1 - 1e-3)) {
      ++stuck;
      EXPECT_LE(size(velocity(p, r)), tolerance<real> * size(p.q)) << i;
      continue;
    }
    double nearest = size(r);
    for (const auto& slip : slips(p)) nearest = std::min(nearest, distance(slip, r));
    if (nearest > tolerance<real> * size(r)) {  // at the border both cases meet: u = 0 and on the cone
      EXPECT_LE(size(velocity(p, r)), 1e-2 * size(p.q)) << i << ": no such slip, nearest at " << nearest / size(r);
    } else {
      ++slipped;
    }
  }
  EXPECT_GT(stuck, 300);
  EXPECT_GT(slipped, 600);
}

TYPED_TEST(Cone, TakesOffWhenBodiesSeparate) {
  using real = TypeParam;
  Random random(12);
  for (int i = 0; i < 100; ++i) {
    Problem p = random_problem(random);
    p.q.normal = -p.q.normal;
    EXPECT_EQ(size(solve<real>(p)), 0);
    p.q.normal = 0;
    EXPECT_EQ(size(solve<real>(p)), 0);
  }
}

TYPED_TEST(Cone, WithoutFrictionOnlyPushesAlongTheNormal) {
  using real = TypeParam;
  Random random(13);
  for (int i = 0; i < 100; ++i) {
    Problem p = random_problem(random);
    p.mu = 0;
    const ConeVector<double> r = solve<real>(p);
    EXPECT_EQ(std::hypot(r.tangent_1, r.tangent_2), 0);
    EXPECT_NEAR(r.normal, -p.q.normal / p.w.nn, 1e-6 * r.normal);
  }
}

// Where W is diagonal the closed form and the general solution are one.
TYPED_TEST(Cone, CentralIsGeneralWithDiagonalBlock) {
  using real = TypeParam;
  Random random(14);
  for (int i = 0; i < 1000; ++i) {
    Problem p = random_problem(random);
    p.w.t22 = p.w.t11;
    p.w.n1 = p.w.n2 = p.w.t12 = 0;
    const ConeVector<double> general = solve<real>(p);
    const auto central = reference::solve_central<real>({real(p.q.normal), real(p.q.tangent_1), real(p.q.tangent_2)},
                                                        real(p.w.nn), real(p.w.t11), real(p.mu));
    EXPECT_LE(distance(general, {double(central.normal), double(central.tangent_1), double(central.tangent_2)}),
              tolerance<real> * size(general));
  }
}

// Blocks of bodies a thousand times heavier and smaller than each other, contacts that hardly press, friction beyond 2:
// always in the cone, never a NaN.
TYPED_TEST(Cone, StaysInTheConeOnExtremeBlocks) {
  using real = TypeParam;
  Random random(15);
  for (int i = 0; i < 20000; ++i) {
    Problem p = random_problem(random);
    p.mu = random.between(0, 20);
    const double scale = std::pow(10, random.between(-6, 6));
    for (double* x : {&p.w.nn, &p.w.t11, &p.w.t22, &p.w.n1, &p.w.n2, &p.w.t12}) *x *= scale;
    p.q.normal *= std::pow(10, random.between(-12, 0));
    const ConeVector<double> r = solve<real>(p);
    EXPECT_TRUE(std::isfinite(r.normal) && r.normal >= 0) << i;
    EXPECT_LE(std::hypot(r.tangent_1, r.tangent_2), p.mu * r.normal * (1 + 1e-5)) << i;
  }
}

}  // namespace
}  // namespace lockstep::test::cone_test
