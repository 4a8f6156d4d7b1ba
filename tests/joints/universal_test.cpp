#include <gtest/gtest.h>

#include <cmath>

#include "host/report/joints.hpp"
#include "tests/bodies.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::universal_test {
namespace {

constexpr double dt = 1e-3;
constexpr double bend = 0.6;  // rad, between two shafts

template <class real>
class UniversalJoint : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(UniversalJoint, Precisions);

JointDescription cross_of(u32 body_a, u32 body_b, const Vector3& anchor, const Vector3& first, const Vector3& second) {
  JointDescription joint = joint_of(JOINT_UNIVERSAL, body_a, body_b, anchor, first);
  joint.second_axis = second;
  return joint;
}

const Vector3 second_shaft = {std::cos(bend), 0, std::sin(bend)};

// A shaft along x that a motor turns at 2 rad/s, and one bent away by an angle. The arm of the first lies in the plane
// of both shafts, that of the second across it.
Scene cardan() {
  Scene scene = joint_scene({bare_body({-0.5, 0, 0}), bare_body(exact::scale(0.5, second_shaft))},
                            {joint_of(JOINT_HINGE, NONE, 0, {-0.5, 0, 0}, {1, 0, 0}),
                             joint_of(JOINT_HINGE, NONE, 1, exact::scale(0.5, second_shaft), second_shaft),
                             cross_of(0, 1, {0, 0, 0}, {0, 0, 1}, {0, 1, 0})},
                            dt);
  scene.joints[0].motor_speed = 2;
  scene.joints[0].motor_force = 1e5;
  scene.bodies[0].angular_velocity = {2, 0, 0};
  scene.bodies[1].angular_velocity = exact::scale(2 / std::cos(bend), second_shaft);
  scene.settings.iterations = 40;
  return scene;
}

// tan(theta_2) = tan(theta_1) / cos(beta), and so w_2 / w_1 = cos(beta) / (1 - sin(beta)^2 cos(theta_1)^2).
TYPED_TEST(UniversalJoint, RotatesABentShaftAsCardanSays) {
  using real = TypeParam;
  for (const u32 substeps : {1u, 2u}) {
    SCOPED_TRACE(substeps);
    const Scene scene = substeps > 1 ? with_small_steps(cardan(), substeps) : cardan();
    double least = 10, most = 0;
    watch_steps<real>(scene, 3200, [&](const Buffers<real>& b, u32 i) {
      const Vector3 w = angular_velocity(b, 1);
      const double driven = dot(w, second_shaft);
      EXPECT_NEAR(double(b.motions[0].w[0]), 2, 1e-3) << i;
      const Quaternion q = orientation(b, 0);
      const double c = std::cos(2 * std::atan2(q[0], q[3])), s = std::sin(bend);
      EXPECT_NEAR(driven / 2, std::cos(bend) / (1 - s * s * c * c), 3e-3) << i;
      least = std::min(least, driven / 2);
      most = std::max(most, driven / 2);
      const JointDrift drift = joint_drift(b);
      EXPECT_LT(drift.separation, 1e-4) << i;
      EXPECT_LT(drift.angle, 1e-4) << i;
    });
    EXPECT_NEAR(least, std::cos(bend), 1e-3);
    EXPECT_NEAR(most, 1 / std::cos(bend), 1e-3);
  }
}

// What hangs from a cross swings about either arm, with the period of the moment about that arm, and does not twist.
TYPED_TEST(UniversalJoint, SwingsAboutBothArmsAndDoesNotTwist) {
  using real = TypeParam;
  const Vector3 moments = {0.1, 0.2, 0.05};
  for (const u32 arm : {0u, 1u}) {
    SCOPED_TRACE(arm);
    Scene scene =
        joint_scene({bare_body({0, 0, -1}, moments)}, {cross_of(NONE, 0, {0, 0, 0}, {1, 0, 0}, {0, 1, 0})}, dt);
    const double rate = std::sqrt(9.81 / (moments[arm] + 1)), swing = 0.02;
    scene.bodies[0].angular_velocity = {arm == 0 ? swing * rate : 0, arm == 1 ? swing * rate : 0, 0.5};
    scene.bodies[0].velocity = {arm == 1 ? -swing * rate : 0, arm == 0 ? swing * rate : 0, 0};
    const InitialState<real> state = compile<real>(scene);
    watch_steps<real>(scene, 2000, [&](const Buffers<real>& b, u32 i) {
      const double angle = swing * std::sin(rate * (i + 1) * dt);
      const Quaternion q = orientation(b, 0);
      EXPECT_NEAR(2 * q[arm], angle, 1e-4) << i;
      EXPECT_NEAR(2 * q[1 - arm], 0, 1e-4) << i;
      EXPECT_NEAR(2 * q[2], 0, 1e-5) << i;
      EXPECT_NEAR(measure_joint(b, state.params, 0).coordinate, arm == 0 ? angle : 0, 1e-4) << i;
    });
  }
}

// The first arm has the angle that a motor drives and limits stop, here while the body hangs askew on the second.
TYPED_TEST(UniversalJoint, MotorAndLimitsActOnTheFirstArm) {
  using real = TypeParam;
  Scene scene =
      joint_scene({bare_body({0, 0, 0}, {0.3, 0.3, 0.3})}, {cross_of(NONE, 0, {0, 0, 0}, {0, 0, 1}, {0, 1, 0})}, dt);
  scene.joints[0].motor_speed = 2;
  scene.joints[0].motor_force = 1.5;
  scene.joints[0].limited = true;
  scene.joints[0].low = -1;
  scene.joints[0].high = 2.5;
  const InitialState<real> state = compile<real>(scene);
  watch_steps<real>(scene, 2000, [&](const Buffers<real>& b, u32 i) {
    const JointMeasures joint = measure_joint(b, state.params, 0);
    if (i < 1000) {
      EXPECT_NEAR(joint.speed, std::min(5 * (i + 1) * dt, 2.0), 1e-3) << i;
    }
    EXPECT_LT(joint.coordinate, 2.5 + 1e-4) << i;
    if (i == 1999) {
      EXPECT_NEAR(joint.coordinate, 2.5, 1e-3);
    }
  });
}

// A shaft carries a torque round the bend: with T_1 w_1 = T_2 w_2 the driven end pushes with T_1 cos(beta) here, where
// the arm of the first lies in the plane of the shafts (w_2 / w_1 = 1 / cos(beta)). The joint tells the rest.
TYPED_TEST(UniversalJoint, CarriesATorqueRoundTheBend) {
  using real = TypeParam;
  Scene scene = cardan();
  scene.gravity = {0, 0, 0};
  for (BodyDescription& body : scene.bodies) body.angular_velocity = {0, 0, 0};
  scene.joints[0].motor_speed = 0;  // holds
  scene.joints[1].motor_speed = 100;
  scene.joints[1].motor_force = 3;  // pushes against it
  scene.settings.iterations = 2000;
  const InitialState<real> state = compile<real>(scene);
  const Buffers<real> b = after_steps<real>(scene, 3);
  EXPECT_NEAR(measure_joint(b, state.params, 0).drive, -3 / std::cos(bend), 1e-3);
  EXPECT_NEAR(measure_joint(b, state.params, 1).drive, 3, 1e-3);
  // along the normal of both arms, x here: what the first shaft feels along its axis
  const Eigen::Vector3d torque = measure_joint(b, state.params, 2).torque;
  EXPECT_NEAR(std::abs(torque.x()), 3 / std::cos(bend), 1e-3);
  EXPECT_NEAR(std::hypot(torque.y(), torque.z()), 0, 1e-3);
}

}  // namespace
}  // namespace lockstep::test::universal_test
