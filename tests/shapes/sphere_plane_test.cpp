#include "cpu_reference/shapes/sphere_plane.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/worlds.hpp"

namespace lockstep::test::sphere_plane_test {
namespace {

template <class real>
class SpherePlane : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SpherePlane, Precisions);

// The third column of the rotation matrix of a quaternion that is unit up to rounding, in long double.
Vector3 z_axis(long double x, long double y, long double z, long double w) {
  const long double s = 2 / (x * x + y * y + z * z + w * w);
  return {double(s * (x * z + w * y)), double(s * (y * z - w * x)), double(1 - s * (x * x + y * y))};
}

template <class real>
Quaternion unit(Random& random) {
  double q[4], sum = 0;
  for (double& x : q) {
    x = random.between(-1, 1);
    sum += x * x;
  }
  return {real(q[0] / std::sqrt(sum)), real(q[1] / std::sqrt(sum)), real(q[2] / std::sqrt(sum)),
          real(q[3] / std::sqrt(sum))};
}

TYPED_TEST(SpherePlane, MatchesTheClosedForm) {
  using real = TypeParam;
  const double ulp = std::numeric_limits<real>::epsilon();
  Random random(2);
  for (int n = 0; n < 2000; ++n) {
    const Quaternion q = unit<real>(random);
    const Vector3 c = random.vector(4), p = random.vector(4);
    const real radius = real(random.between(0.02, 1));
    const reference::WorldShape<real> sphere = {{real(c[0]), real(c[1]), real(c[2])}, {0, 0, 0, 1}, {radius, 0, 0}, 0};
    const reference::WorldShape<real> plane = {
        {real(p[0]), real(p[1]), real(p[2])}, {real(q[0]), real(q[1]), real(q[2]), real(q[3])}, {0, 0, 0}, 0};
    const reference::Manifold<real> touch = reference::sphere_plane(sphere, plane);
    const Vector3 axis = z_axis(q[0], q[1], q[2], q[3]);
    const double height = axis[0] * (double(sphere.center.x) - double(plane.center.x)) +
                          axis[1] * (double(sphere.center.y) - double(plane.center.y)) +
                          axis[2] * (double(sphere.center.z) - double(plane.center.z));
    EXPECT_NEAR(touch.normal.x, axis[0], 8 * ulp);
    EXPECT_NEAR(touch.normal.y, axis[1], 8 * ulp);
    EXPECT_NEAR(touch.normal.z, axis[2], 8 * ulp);
    EXPECT_NEAR(reference::gap_at(touch, 0), height - radius, 160 * ulp);
  }
}

// A shape's frame turned by its body: a plane whose normal points along x in the body, and the body turned by a third
// of a turn about (1, 1, 1), which takes x to y. All products are exact.
TYPED_TEST(SpherePlane, TheBodyRotatesTheNormal) {
  using real = TypeParam;
  Shape<real> shape = {};
  shape.offset[0] = 2;  // the plane stands 2 m from the body's centre along its own normal
  const real half = real(0.5);
  const real x_from_z[4] = {half, half, half, half};  // z -> x: the same third of a turn
  std::ranges::copy(x_from_z, shape.rotation);
  const reference::Pose<real> pose = {{10, 20, 30}, {half, half, half, half}};
  const reference::WorldShape<real> plane = {
      reference::shape_center(pose, shape), reference::shape_rotation(pose, shape), {0, 0, 0}, 0};
  const reference::WorldShape<real> sphere = {{0, 27, 0}, {0, 0, 0, 1}, {1, 0, 0}, 0};
  const reference::Manifold<real> touch = reference::sphere_plane(sphere, plane);
  EXPECT_EQ(touch.normal.x, 0);
  EXPECT_EQ(touch.normal.y, 1);
  EXPECT_EQ(touch.normal.z, 0);
  EXPECT_EQ(reference::gap_at(touch, 0), 4);
}

// A sphere on a level plane touches it exactly, wherever it stands.
TYPED_TEST(SpherePlane, TheGapDoesNotDependOnThePosition) {
  using real = TypeParam;
  Random random(3);
  const reference::WorldShape<real> plane = {{0, 0, 0}, {0, 0, 0, 1}, {0, 0, 0}, 0};
  for (int n = 0; n < 1000; ++n) {
    const Vector3 c = random.vector(100);
    const reference::WorldShape<real> sphere = {
        {real(c[0]), real(c[1]), real(0.5)}, {0, 0, 0, 1}, {real(0.5), 0, 0}, 0};
    EXPECT_EQ(reference::gap_at(reference::sphere_plane(sphere, plane), 0), 0);
  }
}

}  // namespace
}  // namespace lockstep::test::sphere_plane_test
