#include <gtest/gtest.h>

#include "host/report/measures.hpp"
#include "tests/closed_forms.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::ball_test {
namespace {

// A pendulum released from the horizontal passes its lowest point after a quarter of the period
// T = 4 K(sin 45 deg) sqrt(I / (m g L)), I = I_c + m L^2. Returns what is measured over what is true.
double quarter_period_ratio(JointKind kind, double moment, double dt) {
  const double length = 1, inertia = moment + length * length;
  const Scene scene = joint_scene({bare_body({length, 0, 0}, {moment, moment, moment})},
                                  {joint_of(kind, NONE, 0, {0, 0, 0}, {0, 1, 0})}, dt);
  const double exact_time = elliptic_k(std::sqrt(0.5)) * std::sqrt(inertia / (9.81 * length));
  double last = length, time = 0;
  watch_steps<double>(scene, u32(1.5 * exact_time / dt), [&](const Buffers<double>& b, u32 i) {
    const double x = b.positions[0].x;
    if (time == 0 && x < 0) time = (i + last / (last - x)) * dt;
    last = x;
  });
  return time / exact_time;
}

TEST(BallJoint, PendulumHasItsPeriod) {
  for (const double moment : {1e-4, 0.3}) {
    const double coarse = quarter_period_ratio(JOINT_BALL, moment, 2e-3) - 1;
    const double fine = quarter_period_ratio(JOINT_BALL, moment, 1e-3) - 1;
    EXPECT_LT(std::abs(fine), 2e-3) << moment;
    EXPECT_NEAR(coarse / fine, 2, 0.2) << moment;  // first order
  }
}

// A hinge leaves the pendulum the same turn, and its inertia about the axis.
TEST(HingeJoint, DoorHasThePeriodOfAPhysicalPendulum) {
  EXPECT_NEAR(quarter_period_ratio(JOINT_HINGE, 0.3, 1e-3), 1, 2e-3);
}

// The pendulum of the scene pendulum_a01, held by a joint: T = 2.36784195 s.
TEST(BallJoint, PointPendulumIsA01) {
  const double quarter = elliptic_k(std::sqrt(0.5)) / std::sqrt(9.81);
  EXPECT_NEAR(4 * quarter, 2.36784195, 1e-8);
  EXPECT_NEAR(4 * quarter * quarter_period_ratio(JOINT_BALL, 1e-6, 2.5e-4), 2.36784195, 1e-3);
}

template <class real>
class BallJointIn : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(BallJointIn, Precisions);

// Joints of every kind between free bodies: what they do to one they do to the other, at one point.
TYPED_TEST(BallJointIn, MomentumIsConserved) {
  using real = TypeParam;
  for (u32 kind = 0; kind < JOINT_KINDS; ++kind) {
    for (const u32 substeps : {1u, 4u}) {
      BodyDescription a = bare_body({0, 0, 0}, {0.1, 0.2, 0.25}), b = bare_body({1, 0.3, 0}, {0.3, 0.2, 0.15});
      b.mass = 2;
      a.velocity = {1, 0, 0.5};
      a.angular_velocity = {0.3, -1, 0.2};
      b.angular_velocity = {1, 2, -0.4};
      JointDescription joint = joint_of(static_cast<JointKind>(kind), 0, 1, {0.5, 0, 0.1}, {1, 1, 0});
      joint.second_axis = {1, -1, 0};
      if (kind == JOINT_DISTANCE) joint.anchor_b = {1, 0.5, 0};
      if (kind == JOINT_SCREW) joint.pitch = 0.4;
      if (kind == JOINT_ROLLING) joint.radius = 0.2;
      Scene scene = joint_scene({a, b}, {joint}, 1.0 / 240);
      scene.gravity = {0, 0, 0};
      if (substeps > 1) scene = with_small_steps(scene, substeps);
      const InitialState<real> start = compile<real>(scene);
      const Counters none = {};
      const auto world = [&](const Buffers<real>& buffers) {
        return measure(buffers, start.sizes, start.features, start.params, none).worlds[0];
      };
      const WorldMeasures before = world(start.buffers), after = world(after_steps<real>(scene, 240));
      // the integrator turns the bodies under their angular velocity: that is the gyroscopic moment, of first order
      EXPECT_LT((after.momentum - before.momentum).norm(), sizeof(real) == 4 ? 2e-5 : 1e-12) << kind;
      EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 0.05) << kind;
    }
  }
}

// Of isotropic bodies the turn changes no momentum. Where joints are closed by velocities it is kept to rounding,
// however far apart the anchors are; bodies that are moved keep it to second order.
TYPED_TEST(BallJointIn, AngularMomentumIsConserved) {
  using real = TypeParam;
  BodyDescription a = bare_body({0, 0, 0}), b = bare_body({1, 0, 0});
  a.velocity = {3, 1, 0};
  b.angular_velocity = {1, 5, -4};
  Scene scene = joint_scene({a, b}, {joint_of(JOINT_BALL, 0, 1, {0.4, 0.1, 0})}, 1.0 / 60);
  scene.gravity = {0, 0, 0};
  const auto change = [&](u32 steps) {
    const InitialState<real> start = compile<real>(scene);
    const Counters none = {};
    const auto angular = [&](const Buffers<real>& buffers) {
      return measure(buffers, start.sizes, start.features, start.params, none).worlds[0].angular_momentum;
    };
    return (angular(after_steps<real>(scene, steps)) - angular(start.buffers)).norm() / angular(start.buffers).norm();
  };
  scene.settings.stabilization = Stabilization::velocities;
  EXPECT_LT(change(300), sizeof(real) == 4 ? 2e-5 : 1e-13);
  scene.settings.stabilization = Stabilization::positions;
  EXPECT_LT(change(300), 2e-3);
  scene.settings.dt /= 2;
  const double coarse = change(600);
  scene.settings.dt /= 2;
  EXPECT_GT(coarse / change(1200), 3.2);
}

// A chain of 20 links at rest hangs and carries its weight: each joint the mass below it.
TYPED_TEST(BallJointIn, HangingChainCarriesItsWeight) {
  using real = TypeParam;
  const u32 links = 20;
  std::vector<BodyDescription> bodies;
  std::vector<JointDescription> joints;
  for (u32 i = 0; i < links; ++i) {
    bodies.push_back(bare_body({0, 0, -0.5 - i}));
    joints.push_back(joint_of(JOINT_BALL, i == 0 ? NONE : i - 1, i, {0, 0, -1.0 * i}));
  }
  const double dt = 1.0 / 240;
  const Buffers<real> b = after_steps<real>(with_small_steps(joint_scene(bodies, joints, 4 * dt), 4), 400);
  for (u32 slot = 0; slot < b.joint_lanes.size() * PACK; ++slot) {
    const u32 joint = b.joint_lanes[slot / PACK].joint[slot % PACK];
    if (joint == NONE) continue;
    EXPECT_NEAR(double(b.joint_impulses[slot / PACK].locked[2][slot % PACK]), (links - joint) * 9.81 * dt, 5e-3)
        << joint;
  }
}

}  // namespace
}  // namespace lockstep::test::ball_test
