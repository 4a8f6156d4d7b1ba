#include <gtest/gtest.h>

#include <cmath>

#include "host/report/joints.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::slider_and_fixed_test {
namespace {

constexpr double dt = 1.0 / 240;
constexpr double slope = 0.5;  // rad

template <class real>
class SliderJoint : public testing::Test {};
template <class real>
class FixedJoint : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SliderJoint, Precisions);
TYPED_TEST_SUITE(FixedJoint, Precisions);

// Down a slope along +x.
Scene on_slope() {
  return joint_scene({bare_body({0, 0, 0}, {0.1, 0.2, 0.25})},
                     {joint_of(JOINT_SLIDER, NONE, 0, {0.3, 0.2, 0.1}, {std::cos(slope), 0, -std::sin(slope)})}, dt);
}

TYPED_TEST(SliderJoint, SlidesDownASlopeLikeABlock) {
  using real = TypeParam;
  const Buffers<real> b = after_steps<real>(on_slope(), 240);
  const double speed = 9.81 * std::sin(slope) * 240 * dt;
  const double rounding = sizeof(real) == 4 ? 1e-4 : 1e-12;
  EXPECT_NEAR(double(b.motions[0].v[0]), speed * std::cos(slope), rounding);
  EXPECT_NEAR(double(b.motions[0].v[2]), -speed * std::sin(slope), rounding);
  EXPECT_NEAR(double(b.motions[0].w[1]), 0, rounding);
  EXPECT_LT(joint_drift(b).angle, rounding);
}

TYPED_TEST(SliderJoint, MotorPushesWithItsForce) {
  using real = TypeParam;
  Scene scene = on_slope();
  scene.joints[0].motor_speed = -1;  // up the slope
  scene.joints[0].motor_force = 9.81 * std::sin(slope) + 2;
  watch_steps<real>(scene, 240, [&](const Buffers<real>& b, u32 i) {
    EXPECT_NEAR(double(b.motions[0].v[0]), -std::min(2 * (i + 1) * dt, 1.0) * std::cos(slope), 1e-4) << i;
  });
}

TYPED_TEST(SliderJoint, LimitsStopIt) {
  using real = TypeParam;
  for (const u32 substeps : {1u, 4u}) {
    Scene scene = on_slope();
    scene.joints[0].limited = true;
    scene.joints[0].low = -0.1;
    scene.joints[0].high = 0.4;
    if (substeps > 1) scene = with_small_steps(scene, substeps);
    const Buffers<real> b = after_steps<real>(scene, 480);
    EXPECT_NEAR(double(b.positions[0].x), 0.4 * std::cos(slope), 1e-3);
    EXPECT_NEAR(double(b.motions[0].v[0]), 0, 1e-4);
  }
}

// A body on a spring of 2 Hz, damped critically, sinks by g / w^2; small steps do not relax what is meant to give.
TYPED_TEST(SliderJoint, SpringCarriesABody) {
  using real = TypeParam;
  const double w = 2 * 3.141592653589793 * 2;
  for (const u32 substeps : {1u, 4u}) {
    JointDescription spring = joint_of(JOINT_FIXED, NONE, 0, {0, 0, 0});
    spring.frequency = 2;
    Scene scene = joint_scene({bare_body({0, 0, 0})}, {spring}, dt);
    if (substeps > 1) scene = with_small_steps(scene, substeps);
    EXPECT_NEAR(double(after_steps<real>(scene, 1200).positions[0].z), -9.81 / (w * w), 1e-4) << substeps;
  }
}

// Two boxes held end to end, thrown and spinning, move as the one box that they make.
TYPED_TEST(FixedJoint, TwoBoxesMoveAsOne) {
  using real = TypeParam;
  const auto box = [](double mass, double x, double y, double z) {
    return Vector3{mass / 12 * (y * y + z * z), mass / 12 * (x * x + z * z), mass / 12 * (x * x + y * y)};
  };
  const Vector3 angular_velocity = {0.5, 1, -0.7};
  BodyDescription left = bare_body({-0.5, 0, 0}, box(1, 1, 0.4, 0.3)), right = left;
  right.position = {0.5, 0, 0};
  for (BodyDescription* body : {&left, &right}) {
    body->angular_velocity = angular_velocity;
    body->velocity = exact::cross(angular_velocity, body->position);
  }
  BodyDescription whole = bare_body({0, 0, 0}, box(2, 2, 0.4, 0.3));
  whole.mass = 2;
  whole.angular_velocity = angular_velocity;
  const double small = 1.0 / 2000;
  const Scene pieces = joint_scene({left, right}, {joint_of(JOINT_FIXED, 0, 1, {0, 0, 0}, {1, 0, 0})}, small);
  const Buffers<real> two = after_steps<real>(pieces, 2000);
  const Buffers<real> one = after_steps<real>(joint_scene({whole}, {}, small), 2000);
  const double z = (double(two.positions[0].z) + double(two.positions[1].z)) / 2;
  EXPECT_NEAR(z, double(one.positions[0].z), 1e-4);
  for (u32 k = 0; k < 3; ++k) EXPECT_NEAR(double(two.motions[0].w[k]), double(one.motions[0].w[k]), 3e-3);
  EXPECT_NEAR(double(two.orientations[1].x), double(one.orientations[0].x), 2e-3);
  EXPECT_NEAR(double(two.orientations[1].y), double(one.orientations[0].y), 2e-3);
  EXPECT_NEAR(double(two.orientations[1].z), double(one.orientations[0].z), 2e-3);
  EXPECT_LT(joint_drift(two).angle, 1e-3);
}

// A beam of two boxes built into a wall: the root carries the weight of both and its moment, the middle that of one.
TYPED_TEST(FixedJoint, CantileverCarriesForceAndMoment) {
  using real = TypeParam;
  Scene scene = joint_scene({bare_body({0.5, 0, 0}), bare_body({1.5, 0, 0})},
                            {joint_of(JOINT_FIXED, NONE, 0, {0, 0, 0}), joint_of(JOINT_FIXED, 0, 1, {1, 0, 0})}, dt);
  scene.settings.iterations = 30;
  const Buffers<real> b = after_steps<real>(scene, 240);
  const auto impulse = [&](u32 joint, u32 row) {
    for (u32 slot = 0;; ++slot) {
      if (b.joint_lanes[slot / PACK].joint[slot % PACK] == joint)
        return double(b.joint_impulses[slot / PACK].locked[row][slot % PACK]);
    }
  };
  EXPECT_NEAR(impulse(0, 2), 2 * 9.81 * dt, 1e-4);
  EXPECT_NEAR(impulse(0, 4), -(0.5 + 1.5) * 9.81 * dt, 1e-4);
  EXPECT_NEAR(impulse(1, 2), 9.81 * dt, 1e-4);
  EXPECT_NEAR(impulse(1, 4), -0.5 * 9.81 * dt, 1e-4);
  EXPECT_NEAR(double(b.positions[1].z), 0, 1e-3);
}

}  // namespace
}  // namespace lockstep::test::slider_and_fixed_test
