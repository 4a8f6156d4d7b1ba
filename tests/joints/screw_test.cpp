#include <gtest/gtest.h>

#include <cmath>

#include "host/report/joints.hpp"
#include "tests/bodies.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::screw_test {
namespace {

constexpr double dt = 1.0 / 240;
constexpr double two_pi = 6.283185307179586;
constexpr double moment = 0.02;  // kg m^2 of a nut of 1 kg, about the spindle

template <class real>
class ScrewJoint : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ScrewJoint, Precisions);

// A nut on a vertical spindle.
Scene nut(double pitch) {
  Scene scene =
      joint_scene({bare_body({0, 0, 0}, {0.012, 0.015, moment})}, {joint_of(JOINT_SCREW, NONE, 0, {0, 0, 0})}, dt);
  scene.joints[0].pitch = pitch;
  return scene;
}

// m g is shared by the mass and by the moment behind the thread: a = g / (1 + I (2 pi / pitch)^2 / m). The nut goes
// through many turns; a left-handed one turns the other way.
TYPED_TEST(ScrewJoint, ANutFallsAsItsThreadLets) {
  using real = TypeParam;
  for (const double pitch : {0.5, -0.5, 0.02}) {
    for (const u32 substeps : {1u, 4u}) {
      SCOPED_TRACE(std::to_string(pitch) + " " + std::to_string(substeps));
      const Scene scene = substeps > 1 ? with_small_steps(nut(pitch), substeps) : nut(pitch);
      const InitialState<real> state = compile<real>(scene);
      const double a = 9.81 / (1 + moment * std::pow(two_pi / pitch, 2));
      const double relative = sizeof(real) == 4 ? 1e-4 : 1e-9;
      watch_steps<real>(scene, 480, [&](const Buffers<real>& b, u32 i) {
        const double v = -a * (i + 1) * dt;
        ASSERT_NEAR(double(b.motions[0].v[2]), v, relative * std::abs(v)) << i;
        ASSERT_NEAR(double(b.motions[0].w[2]), v * two_pi / pitch, relative * std::abs(v * two_pi / pitch)) << i;
        const JointMeasures joint = measure_joint(b, state.params, 0);
        ASSERT_LT(joint.drift.separation, 1e-4) << i;
        ASSERT_NEAR(joint.coordinate, position(b, 0)[2] * two_pi / pitch, 1e-4 * two_pi / std::abs(pitch)) << i;
      });
      if (std::abs(pitch) == 0.5) {
        EXPECT_GT(0.5 * a * 4 / 0.5, 9) << "turns";
      }
    }
  }
}

// The torque M of a motor is a force 2 pi M / pitch along the spindle; m g pitch / 2 pi holds the nut.
TYPED_TEST(ScrewJoint, AMotorLiftsByTheThread) {
  using real = TypeParam;
  const double pitch = 0.05, static_torque = 9.81 * pitch / two_pi;
  for (const double torque : {0.5 * static_torque, 2 * static_torque}) {
    Scene scene = nut(pitch);
    scene.joints[0].motor_speed = 100;
    scene.joints[0].motor_force = torque;
    const InitialState<real> state = compile<real>(scene);
    const Buffers<real> b = after_steps<real>(scene, 240);
    const double a = (torque - static_torque) * two_pi / pitch / (1 + moment * std::pow(two_pi / pitch, 2));
    EXPECT_NEAR(double(b.motions[0].v[2]), a, 1e-4 * std::abs(a));
    const JointMeasures joint = measure_joint(b, state.params, 0);
    EXPECT_NEAR(joint.drive, torque, 1e-4);
    // the thread: what lifts, and the moment that turns the nut on
    const double lift = 9.81 + a;
    EXPECT_NEAR(joint.force.z(), lift, 1e-3);
    EXPECT_NEAR(joint.torque.z(), -lift * pitch / two_pi, 1e-4);
  }
}

// A limit may lie turns away.
TYPED_TEST(ScrewJoint, LimitsCountWholeRevolutions) {
  using real = TypeParam;
  const double pitch = 0.3;
  for (const u32 substeps : {1u, 4u}) {
    Scene scene = nut(pitch);
    scene.joints[0].limited = true;
    scene.joints[0].low = -3.5 * two_pi;
    scene.joints[0].high = 1;
    if (substeps > 1) scene = with_small_steps(scene, substeps);
    const Buffers<real> b = after_steps<real>(scene, 720);
    EXPECT_NEAR(position(b, 0)[2], -3.5 * pitch, 1e-3);
    EXPECT_NEAR(double(b.motions[0].v[2]), 0, 1e-4);
  }
}

// A spring winds up over turns: at rest k angle = m g pitch / 2 pi.
TYPED_TEST(ScrewJoint, ASpringWindsUp) {
  using real = TypeParam;
  const double pitch = 0.3, angle = -2.25 * two_pi, k = -9.81 * pitch / two_pi / angle;
  Scene scene = nut(pitch);
  scene.joints[0].spring = {.stiffness = k, .damping = 0.05, .rest = 0};
  const InitialState<real> state = compile<real>(scene);
  const Buffers<real> b = after_steps<real>(scene, 4800);
  EXPECT_NEAR(measure_joint(b, state.params, 0).coordinate, angle, 1e-3);
  EXPECT_NEAR(spring_energy(b, state.params, 0), 0.5 * k * angle * angle, 1e-3);
}

// Bolt and nut in free flight: neither momentum changes, while the nut runs along the thread.
TYPED_TEST(ScrewJoint, FreeBoltAndNutKeepTheirMomenta) {
  using real = TypeParam;
  const double pitch = 0.2;
  BodyDescription bolt = bare_body({0, 0, 0}, {0.1, 0.1, 0.03}), nut = bare_body({0, 0, 0.5}, {0.012, 0.012, moment});
  bolt.mass = 3;
  nut.angular_velocity = {0, 0, 8};
  Scene scene = joint_scene({bolt, nut}, {joint_of(JOINT_SCREW, 0, 1, {0, 0, 0.2})}, dt);
  scene.gravity = {0, 0, 0};
  scene.joints[0].pitch = pitch;
  const InitialState<real> state = compile<real>(scene);
  watch_steps<real>(scene, 240, [&](const Buffers<real>& b, u32 i) {
    const auto &m = b.motions[0], &n = b.motions[1];
    EXPECT_NEAR(3 * double(m.v[2]) + double(n.v[2]), 0, 1e-5) << i;
    EXPECT_NEAR(0.03 * double(m.w[2]) + moment * double(n.w[2]), moment * 8, 1e-5) << i;
    EXPECT_NEAR(double(n.v[2] - m.v[2]), double(n.w[2] - m.w[2]) * pitch / two_pi, 1e-5) << i;
    EXPECT_LT(joint_drift(b).separation, 1e-5) << i;
  });
}

}  // namespace
}  // namespace lockstep::test::screw_test
