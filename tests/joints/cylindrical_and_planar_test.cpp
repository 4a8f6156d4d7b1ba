#include <gtest/gtest.h>

#include <cmath>

#include "host/report/joints.hpp"
#include "tests/bodies.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::cylindrical_and_planar_test {
namespace {

constexpr double dt = 1.0 / 240;
constexpr double slope = 0.5;  // rad

template <class real>
class CylindricalJoint : public testing::Test {};
template <class real>
class PlanarJoint : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(CylindricalJoint, Precisions);
TYPED_TEST_SUITE(PlanarJoint, Precisions);

template <class real>
constexpr double rounding = sizeof(real) == 4 ? 1e-4 : 1e-11;

// A level shaft along x, and a body whose centre is on it. The anchor is elsewhere on the shaft.
Scene on_shaft() {
  Scene scene = joint_scene({bare_body({0, 0, 0}, {0.1, 0.15, 0.2})},
                            {joint_of(JOINT_CYLINDRICAL, NONE, 0, {0.4, 0, 0}, {1, 0, 0})}, dt);
  scene.bodies[0].velocity = {0.5, 0, 0};
  scene.bodies[0].angular_velocity = {3, 0, 0};
  return scene;
}

TYPED_TEST(CylindricalJoint, SlidesAndRotatesAsItBeganAndIsCarried) {
  using real = TypeParam;
  for (const u32 substeps : {1u, 4u}) {
    SCOPED_TRACE(substeps);
    const Scene scene = substeps > 1 ? with_small_steps(on_shaft(), substeps) : on_shaft();
    const InitialState<real> state = compile<real>(scene);
    const Buffers<real> b = after_steps<real>(scene, 480);
    EXPECT_NEAR(double(b.motions[0].v[0]), 0.5, rounding<real>);
    EXPECT_NEAR(double(b.motions[0].w[0]), 3, rounding<real>);
    EXPECT_NEAR(position(b, 0)[0], 1, 10 * rounding<real>);
    EXPECT_NEAR(position(b, 0)[2], 0, 1e-4);
    const JointMeasures joint = measure_joint(b, state.params, 0);
    EXPECT_NEAR(joint.coordinate, 1, 10 * rounding<real>);
    EXPECT_NEAR(joint.speed, 0.5, rounding<real>);
    EXPECT_NEAR(joint.force.z(), 9.81, 1e-3);
    EXPECT_NEAR(joint.force.x(), 0, 1e-6);
    EXPECT_LT(joint.drift.separation, 1e-4);
    EXPECT_LT(joint.drift.angle, 1e-4);
  }
}

// What hangs beside the shaft turns as a pendulum about it, a quarter of a turn while it slides on.
TYPED_TEST(CylindricalJoint, WhatHangsBesideSwingsAsOnAHinge) {
  using real = TypeParam;
  Scene scene = on_shaft();
  scene.bodies[0].position = {0, 0.3, 0};
  scene.bodies[0].angular_velocity = {0, 0, 0};
  Scene hinge = scene;
  hinge.joints[0].kind = JOINT_HINGE;
  hinge.bodies[0].velocity = {0, 0, 0};
  const Buffers<real> slides = after_steps<real>(scene, 100), swings = after_steps<real>(hinge, 100);
  EXPECT_NEAR(position(slides, 0)[0], 0.5 * 100 * dt, 1e-4);
  for (u32 k = 1; k < 3; ++k) EXPECT_NEAR(position(slides, 0)[k], position(swings, 0)[k], 1e-4);
  EXPECT_NEAR(double(slides.motions[0].w[0]), double(swings.motions[0].w[0]), 1e-4);
  EXPECT_GT(std::abs(double(slides.motions[0].w[0])), 1);
}

// Motor and limits act on the travel; the spin goes on.
TYPED_TEST(CylindricalJoint, MotorAndLimitsActOnTheTravel) {
  using real = TypeParam;
  Scene scene = on_shaft();
  scene.bodies[0].velocity = {0, 0, 0};
  scene.joints[0].motor_speed = 2;
  scene.joints[0].motor_force = 1.5;
  scene.joints[0].limited = true;
  scene.joints[0].low = -1;
  scene.joints[0].high = 0.8;
  watch_steps<real>(scene, 480, [&](const Buffers<real>& b, u32 i) {
    if (1.5 * (i + 2) * dt < 1.5) {
      EXPECT_NEAR(double(b.motions[0].v[0]), 1.5 * (i + 1) * dt, 1e-4) << i;
    }
    EXPECT_LT(position(b, 0)[0], 0.8 + 1e-5) << i;
    EXPECT_NEAR(double(b.motions[0].w[0]), 3, rounding<real>) << i;
    if (i == 479) {
      EXPECT_NEAR(position(b, 0)[0], 0.8, 1e-4);
    }
  });
}

// On a plane that falls along +x, by its normal; spinning.
Scene on_plane() {
  Scene scene =
      joint_scene({bare_body({0, 0, 0}, {0.1, 0.1, 0.25})},
                  {joint_of(JOINT_PLANAR, NONE, 0, {0.3, 0.2, 0}, {std::sin(slope), 0, std::cos(slope)})}, dt);
  scene.bodies[0].orientation = exact::rotation({0, 1, 0}, std::sin(slope / 2), std::cos(slope / 2));
  scene.bodies[0].angular_velocity = {2 * std::sin(slope), 0, 2 * std::cos(slope)};
  scene.bodies[0].velocity = {0, 0.7, 0};
  return scene;
}

TYPED_TEST(PlanarJoint, SlidesDownItsPlaneWhileItRotates) {
  using real = TypeParam;
  for (const u32 substeps : {1u, 4u}) {
    SCOPED_TRACE(substeps);
    const Scene scene = substeps > 1 ? with_small_steps(on_plane(), substeps) : on_plane();
    const InitialState<real> state = compile<real>(scene);
    const Buffers<real> b = after_steps<real>(scene, 240);
    const double speed = 9.81 * std::sin(slope), tolerance = substeps > 1 ? 1e-4 : rounding<real>;
    EXPECT_NEAR(double(b.motions[0].v[0]), speed * std::cos(slope), tolerance);
    EXPECT_NEAR(double(b.motions[0].v[1]), 0.7, tolerance);
    EXPECT_NEAR(double(b.motions[0].v[2]), -speed * std::sin(slope), tolerance);
    EXPECT_NEAR(double(b.motions[0].w[0]), 2 * std::sin(slope), tolerance);
    EXPECT_NEAR(double(b.motions[0].w[2]), 2 * std::cos(slope), tolerance);
    EXPECT_NEAR(position(b, 0)[1], 0.7, 10 * tolerance);
    const JointMeasures joint = measure_joint(b, state.params, 0);
    EXPECT_NEAR(joint.coordinate, 2, 10 * tolerance);
    EXPECT_NEAR(joint.force.norm(), 9.81 * std::cos(slope), 1e-3);
    EXPECT_LT(joint.drift.separation, 1e-4);
    EXPECT_LT(joint.drift.angle, 1e-4);
  }
}

TYPED_TEST(PlanarJoint, MotorAndLimitsActOnTheAngle) {
  using real = TypeParam;
  Scene scene = on_plane();
  scene.bodies[0].angular_velocity = {0, 0, 0};
  scene.joints[0].anchor_a = scene.joints[0].anchor_b = {0, 0, 0};
  scene.joints[0].motor_speed = 3;
  scene.joints[0].motor_force = 0.5;  // on 0.25 kg m^2
  scene.joints[0].limited = true;
  scene.joints[0].low = -1;
  scene.joints[0].high = 0.6;
  const InitialState<real> state = compile<real>(scene);
  watch_steps<real>(scene, 240, [&](const Buffers<real>& b, u32 i) {
    const JointMeasures joint = measure_joint(b, state.params, 0);
    if (i < 150) {
      EXPECT_NEAR(joint.speed, 2 * (i + 1) * dt, 1e-4) << i;
    }
    EXPECT_LT(joint.coordinate, 0.6 + 1e-5) << i;
    if (i == 239) {
      EXPECT_NEAR(joint.coordinate, 0.6, 1e-4);
    }
  });
}

}  // namespace
}  // namespace lockstep::test::cylindrical_and_planar_test
