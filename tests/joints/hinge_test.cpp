#include <gtest/gtest.h>

#include <cmath>

#include "host/report/joints.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::hinge_test {
namespace {

template <class real>
class HingeJoint : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(HingeJoint, Precisions);

constexpr double dt = 1.0 / 240;

// A door of 1 kg on a vertical axis: its centre is half a metre out, its moment about the axis 0.2 + 0.25 kg m^2.
Scene door() {
  Scene scene =
      joint_scene({bare_body({0.5, 0, 0}, {0.1, 0.15, 0.2})}, {joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0})}, dt);
  scene.gravity = {0, 0, 0};
  return scene;
}

TYPED_TEST(HingeJoint, MotorReachesItsSpeedWithItsTorque) {
  using real = TypeParam;
  Scene scene = door();
  scene.joints[0].motor_speed = 2;
  scene.joints[0].motor_force = 1.5;
  scene.settings.correction = 0;
  watch_steps<real>(scene, 300, [&](const Buffers<real>& b, u32 i) {
    EXPECT_NEAR(double(b.motions[0].w[2]), std::min(1.5 * (i + 1) * dt / 0.45, 2.0), 3e-3) << i;
  });
}

// b against a: a motor between two bodies turns the second, and the first the other way.
TYPED_TEST(HingeJoint, MotorRotatesBothBodies) {
  using real = TypeParam;
  BodyDescription a = bare_body({0, 0, 0}, {1, 1, 3}), b = bare_body({0, 0, 1}, {1, 1, 1});
  Scene scene = joint_scene({a, b}, {joint_of(JOINT_HINGE, 0, 1, {0, 0, 0.5})}, dt);
  scene.gravity = {0, 0, 0};
  scene.joints[0].motor_speed = 4;
  scene.joints[0].motor_force = 1e4;
  const Buffers<real> after = after_steps<real>(scene, 3);
  EXPECT_NEAR(double(after.motions[0].w[2]), -1, 1e-5);
  EXPECT_NEAR(double(after.motions[1].w[2]), 3, 1e-5);
}

TYPED_TEST(HingeJoint, LimitsStopIt) {
  using real = TypeParam;
  for (const double speed : {2.0, -2.0}) {
    for (const u32 substeps : {1u, 4u}) {
      Scene scene = door();
      scene.bodies[0].angular_velocity = {0, 0, speed};
      scene.bodies[0].velocity = {0, 0.5 * speed, 0};
      scene.joints[0].limited = true;
      scene.joints[0].low = -0.25;
      scene.joints[0].high = 0.5;
      if (substeps > 1) scene = with_small_steps(scene, substeps);
      double furthest = 0, w = 1;
      watch_steps<real>(scene, 240, [&](const Buffers<real>& b, u32) {
        const double angle = 2 * std::asin(double(b.orientations[0].z));
        furthest = std::max(furthest, std::abs(angle));
        w = double(b.motions[0].w[2]);
      });
      EXPECT_NEAR(furthest, speed > 0 ? 0.5 : 0.25, 1e-3);
      EXPECT_NEAR(w, 0, 1e-4);
    }
  }
}

// The limit holds a weight: its moment about the axis is m g L.
TYPED_TEST(HingeJoint, LimitCarriesAMoment) {
  using real = TypeParam;
  Scene scene = joint_scene({bare_body({0.5, 0, 0})}, {joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0}, {0, 1, 0})}, dt);
  scene.joints[0].limited = true;
  scene.joints[0].low = -1;
  scene.joints[0].high = 0;  // about +y a weight at +x falls to greater angles
  const Buffers<real> b = after_steps<real>(scene, 240);
  EXPECT_NEAR(double(b.joint_impulses[0].free[0]), -9.81 * 0.5 * dt, 1e-4);
  EXPECT_NEAR(double(b.positions[0].z), 0, 1e-3);
}

// The axis stays where it is against a moment that would tilt it.
TYPED_TEST(HingeJoint, AxisIsKept) {
  using real = TypeParam;
  Scene scene = door();
  scene.gravity = {0, 0, -9.81};
  scene.bodies[0].angular_velocity = {0, 0, 3};
  scene.bodies[0].velocity = {0, 1.5, 0};
  watch_steps<real>(with_small_steps(scene, 4), 480, [&](const Buffers<real>& b, u32) {
    const JointDrift drift = joint_drift(b);
    EXPECT_LT(drift.angle, 2e-4);
    EXPECT_LT(drift.separation, 2e-4);
  });
}

}  // namespace
}  // namespace lockstep::test::hinge_test
