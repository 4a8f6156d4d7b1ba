#include "cpu_reference/shapes/sphere_sphere.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/worlds.hpp"

namespace lockstep::test::sphere_sphere_test {
namespace {

template <class real>
reference::WorldShape<real> sphere(Vector3 center, double radius) {
  return {{real(center[0]), real(center[1]), real(center[2])}, {0, 0, 0, 1}, {real(radius), 0, 0}, 0};
}

template <class real>
class SphereSphere : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SphereSphere, Precisions);

// Closed form in long double, from the inputs as rounded: the rounding of the gap is that of three distances.
TYPED_TEST(SphereSphere, MatchesTheClosedForm) {
  using real = TypeParam;
  const long double ulp = std::numeric_limits<real>::epsilon();
  Random random(1);
  for (int n = 0; n < 2000; ++n) {
    const auto a = sphere<real>(random.vector(2), random.between(0.02, 1));
    const auto b = sphere<real>(random.vector(2), random.between(0.02, 1));
    const reference::Manifold<real> touch = reference::sphere_sphere(a, b);
    const long double d[3] = {(long double)a.center.x - b.center.x, (long double)a.center.y - b.center.y,
                              (long double)a.center.z - b.center.z};
    const long double distance = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const long double gap = distance - a.size.x - b.size.x;
    EXPECT_NEAR(reference::gap_at(touch, 0), gap, 4 * ulp * (distance + a.size.x + b.size.x));
    const real normal[3] = {touch.normal.x, touch.normal.y, touch.normal.z};
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(normal[k], d[k] / distance, 4 * ulp);
    EXPECT_EQ(touch.points[0].anchor_a.x, a.center.x);
    EXPECT_EQ(touch.points[0].anchor_b.y, b.center.y);
    EXPECT_EQ(touch.radius_a, a.size.x);
    EXPECT_EQ(touch.radius_b, b.size.x);
  }
}

TYPED_TEST(SphereSphere, CoincidentCentresSeparateAlongZ) {
  using real = TypeParam;
  const auto touch = reference::sphere_sphere(sphere<real>({1, 2, 3}, 0.5), sphere<real>({1, 2, 3}, 0.25));
  EXPECT_EQ(touch.normal.x, 0);
  EXPECT_EQ(touch.normal.y, 0);
  EXPECT_EQ(touch.normal.z, 1);
  EXPECT_EQ(reference::gap_at(touch, 0), real(-0.75));
}

// Along an axis and with dyadic sizes every operation is exact.
TYPED_TEST(SphereSphere, TouchingSpheresHaveAGapOfZero) {
  using real = TypeParam;
  const auto touch = reference::sphere_sphere(sphere<real>({-1.5, 8, 4}, 1.25), sphere<real>({0.25, 8, 4}, 0.5));
  EXPECT_EQ(reference::gap_at(touch, 0), 0);
  EXPECT_EQ(touch.normal.x, -1);
}

}  // namespace
}  // namespace lockstep::test::sphere_sphere_test
