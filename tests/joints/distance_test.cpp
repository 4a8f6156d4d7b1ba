#include <gtest/gtest.h>

#include <cmath>

#include "host/report/joints.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::distance_test {
namespace {

template <class real>
class DistanceJoint : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(DistanceJoint, Precisions);

constexpr double dt = 1.0 / 240;

// A bob on a rod from the origin.
Scene bob(const Vector3& position) {
  JointDescription rod = joint_of(JOINT_DISTANCE, NONE, 0, {0, 0, 0});
  rod.anchor_b = position;
  return joint_scene({bare_body(position)}, {rod}, dt);
}

TYPED_TEST(DistanceJoint, HangingBobPullsWithItsWeight) {
  using real = TypeParam;
  for (const u32 substeps : {1u, 4u}) {
    const Scene scene = substeps > 1 ? with_small_steps(bob({0, 0, -2}), substeps) : bob({0, 0, -2});
    const Buffers<real> b = after_steps<real>(scene, 240);
    EXPECT_NEAR(double(b.joint_impulses[0].free[0]), -9.81 * dt / substeps, 1e-5);
    EXPECT_NEAR(double(b.positions[0].z), -2, 1e-4);
  }
}

// Round and round at the angle a from the vertical: w^2 = g / (L cos a).
TYPED_TEST(DistanceJoint, ConicalPendulumKeepsItsHeight) {
  using real = TypeParam;
  const double length = 1.5, angle = 0.6, radius = length * std::sin(angle);
  const double w = std::sqrt(9.81 / (length * std::cos(angle)));
  Scene scene = bob({radius, 0, -length * std::cos(angle)});
  scene.bodies[0].velocity = {0, w * radius, 0};
  const u32 substeps = 16, steps = 480;
  const Buffers<real> b = after_steps<real>(with_small_steps(scene, substeps), steps);
  const double azimuth = std::atan2(double(b.positions[0].y), double(b.positions[0].x));
  EXPECT_NEAR(double(b.positions[0].z), -length * std::cos(angle), 2e-3);
  EXPECT_NEAR(std::remainder(azimuth - w * steps * dt, 2 * 3.141592653589793), 0, 1e-2);
}

// A rope may go slack, and stops what falls into it.
TYPED_TEST(DistanceJoint, RopePullsOnlyWhenTaut) {
  using real = TypeParam;
  Scene scene = bob({0, 0, -1});
  scene.joints[0].limited = true;
  scene.joints[0].high = 1.5;
  bool fell_freely = false;
  double lowest = 0;
  watch_steps<real>(scene, 240, [&](const Buffers<real>& b, u32 i) {
    if (i == 59) fell_freely = std::abs(double(b.motions[0].v[2]) + 9.81 * 60 * dt) < 1e-4;
    lowest = std::min(lowest, double(b.positions[0].z));
  });
  EXPECT_TRUE(fell_freely);
  EXPECT_NEAR(lowest, -1.5, 1e-3);
}

// A motor draws the bob in at its speed.
TYPED_TEST(DistanceJoint, WinchDrawsIn) {
  using real = TypeParam;
  Scene scene = bob({0, 0, -2});
  scene.joints[0].limited = true;
  scene.joints[0].low = 0.5;
  scene.joints[0].high = 2;
  scene.joints[0].motor_speed = -0.5;
  scene.joints[0].motor_force = 20;
  const Buffers<real> b = after_steps<real>(scene, 240);
  EXPECT_NEAR(double(b.positions[0].z), -1.5, 0.03);
  EXPECT_NEAR(double(b.motions[0].v[2]), 0.5, 1e-4);
}

}  // namespace
}  // namespace lockstep::test::distance_test
