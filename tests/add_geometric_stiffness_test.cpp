// Light bodies between joints that carry much, in closed form and in steps that are long for how they swing.
#include <cmath>
#include <cstring>
#include <numbers>

#include "host/report/joints.hpp"
#include "host/report/measures.hpp"
#include "tests/bodies.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::add_geometric_stiffness_test {
namespace {

template <class real>
class AddGeometricStiffness : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(AddGeometricStiffness, Precisions);

constexpr double g = 9.81, link_length = 0.2, link_mass = 0.1, ball_radius = 0.3;

// Rods in a row from the origin, in the plane of x and z at `angle` from straight down, and a ball of so many kg.
Scene chain(u32 rods, double load, double angle, JointKind kind = JOINT_BALL) {
  const Vector3 along = {std::sin(angle), 0, -std::cos(angle)};
  std::vector<BodyDescription> bodies;
  std::vector<JointDescription> joints;
  const double across = link_mass * link_length * link_length / 12;
  for (u32 i = 0; i < rods; ++i) {
    bodies.push_back(bare_body((i + 0.5) * link_length * along, {1e-5, across, across}));
    bodies.back().mass = link_mass;
    bodies.back().orientation = {0, std::sin((angle - std::numbers::pi / 2) / 2), 0,
                                 std::cos((angle - std::numbers::pi / 2) / 2)};
    joints.push_back(joint_of(kind, i == 0 ? NONE : i - 1, i, i * link_length * along, {0, 1, 0}));
  }
  const double solid = 0.4 * load * ball_radius * ball_radius;
  bodies.push_back(bare_body((rods * link_length + ball_radius) * along, {solid, solid, solid}));
  bodies.back().mass = load;
  joints.push_back(joint_of(kind, rods - 1, rods, rods * link_length * along, {0, 1, 0}));
  return joint_scene(bodies, joints, 1.0 / 60);
}

double pendulum_length(u32 rods) { return rods * link_length + ball_radius; }

// The state before the stage, in the second step.
template <class real>
void run_twins(const Scene& scene, u32 steps) {
  InitialState<real> state = compile<real>(scene);
  ReferenceBackend<real> backend(state);
  for (u32 i = 0; i < steps; ++i) step(backend, state.params);
  backend.run(Stage::begin_step, state.params);
  backend.run(Stage::integrate_velocities, state.params);
  run_one_stage<real>(Stage::add_geometric_stiffness, backend.buffers(), state.sizes, state.features, state.params);
}

TYPED_TEST(AddGeometricStiffness, KernelMatchesReference) {
  using real = TypeParam;
  for (const double angle : {0.0, 1.0}) {
    run_twins<real>(chain(10, 100, angle), 20);
    run_twins<real>(chain(3, 1000, angle, JOINT_HINGE), 5);
  }
  run_twins<real>(random_joints(1, 40, 90), 3);
  run_twins<real>(random_joints(2, 300, 700), 2);
  run_twins<real>(with_small_steps(chain(10, 1000, 1), 4), 5);
}

// k = T l of a rod of length l that T is on at both ends: it counts for h^2 T l / 2 at least.
TYPED_TEST(AddGeometricStiffness, ARodHasTheLeastInertia) {
  using real = TypeParam;
  const u32 rods = 4;
  const double load = 100;
  const Scene scene = chain(rods, load, 0);
  const InitialState<real> state = compile<real>(scene);
  ReferenceBackend<real> backend(state);
  for (u32 i = 0; i < 20; ++i) step(backend, state.params);
  const double h = scene.settings.dt;
  for (u32 i = 0; i < rods; ++i) {
    const double above = (load + (rods - i) * link_mass) * g, below = above - link_mass * g;
    const double inertia = h * h * (above + below) / 2 * link_length / 2;
    EXPECT_NEAR(double(backend.buffers().motions[i].inertia_yy) * inertia, 1, 1e-3) << i;
  }
  EXPECT_NEAR(double(backend.buffers().motions[rods].inertia_yy) * scene.bodies[rods].inertia[1], 1, 1e-6)
      << "the ball";
}

// What a step can follow, and what carries nothing, is as it was.
TYPED_TEST(AddGeometricStiffness, WhatAStepFollowsKeepsItsBits) {
  using real = TypeParam;
  Scene scene = chain(10, 1, 1);
  scene.settings.dt = 1e-3;
  const Buffers<real> with = after_steps<real>(scene, 200);
  scene.settings.geometric_stiffness = false;
  const Buffers<real> without = after_steps<real>(scene, 200);
  EXPECT_EQ(
      std::memcmp(with.positions.data(), without.positions.data(), sizeof(with.positions[0]) * with.positions.size()),
      0);
  EXPECT_EQ(std::memcmp(with.motions.data(), without.motions.data(), sizeof(with.motions[0]) * with.motions.size()), 0);
}

TEST(GeometricStiffness, IsLeftOutWhereNobodyAsks) {
  Scene scene = chain(2, 1, 0);
  EXPECT_TRUE(has(compile<float>(scene).features, Feature::geometric_stiffness));
  scene.settings.geometric_stiffness = false;
  const InitialState<float> state = compile<float>(scene);
  EXPECT_FALSE(has(state.features, Feature::geometric_stiffness));
  EXPECT_TRUE(state.buffers.body_joints.empty());
  scene.joints.clear();
  scene.settings.geometric_stiffness = true;
  EXPECT_FALSE(has(compile<float>(scene).features, Feature::geometric_stiffness));
}

struct Swing {
  u32 rods;
  double load;   // kg, on rods of 0.1 kg
  double angle;  // at which it is let go, rad
  JointKind kind;
};

std::ostream& operator<<(std::ostream& out, const Swing& swing) {
  return out << swing.rods << " rods, " << swing.load << " kg, " << swing.angle << " rad, " << name_of(swing.kind);
}

class HeavyEnds : public testing::TestWithParam<Swing> {};

INSTANTIATE_TEST_SUITE_P(Chains, HeavyEnds,
                         testing::Values(Swing{10, 10, 1.5707963, JOINT_BALL}, Swing{10, 100, 1.5707963, JOINT_BALL},
                                         Swing{10, 1000, 1.5707963, JOINT_BALL}, Swing{10, 100, 1.5707963, JOINT_HINGE},
                                         Swing{3, 100, 1, JOINT_BALL}, Swing{30, 100, 1.5707963, JOINT_BALL},
                                         Swing{10, 100, 0.6, JOINT_BALL}, Swing{30, 10, 1, JOINT_UNIVERSAL}));

// A wrecking ball, 5 s by all defaults at 1/60 s: no joint opens by a hundredth of a rod's half length, and it swings
// with the energy that it has.
template <class real>
void expect_to_swing(const Swing& swing) {
  const Scene scene = chain(swing.rods, swing.load, swing.angle, swing.kind);
  const InitialState<real> state = compile<real>(scene);
  const Counters none = {};
  const double range = 2 * (swing.load * pendulum_length(swing.rods)) * g * (1 - std::cos(swing.angle));
  double widest = 0, start = 0, highest = 0, last = 0;
  watch_steps<real>(scene, 300, [&](const Buffers<real>& b, u32 i) {
    widest = std::max(widest, joint_drift(b).separation);
    last = measure(b, state.sizes, state.features, state.params, none).energy();
    if (i == 0) start = last;
    highest = std::max(highest, last - start);
  });
  EXPECT_LT(widest, 0.01 * link_length / 2);
  EXPECT_LT(highest, 0.03 * range);
  EXPECT_LT(start - last, 0.05 * range);
}

TEST_P(HeavyEnds, SwingInFloat) { expect_to_swing<float>(GetParam()); }
TEST_P(HeavyEnds, SwingInDouble) { expect_to_swing<double>(GetParam()); }

}  // namespace
}  // namespace lockstep::test::add_geometric_stiffness_test
