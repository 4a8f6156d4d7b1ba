// The forces that a recording has, against closed forms, and that a replay on the device computes the same ones.
#include <gtest/gtest.h>

#include "host/record/replay.hpp"
#include "include/lockstep/world.hpp"
#include "tests/stage_harness.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::recorded_forces_test {
namespace {

constexpr double gravity = 9.81, dt = 0.01;

Scene ground(const char* precision, u32 substeps) {
  Scene scene;
  scene.name = scene.source = "ground";
  scene.settings.dt = dt;
  scene.settings.precision = precision;
  scene.gravity = {0, 0, -gravity};
  replace_solver(scene.settings, Solver::small_steps);
  scene.settings.substeps = substeps;
  BodyDescription floor;
  floor.kind = BODY_STATIC;
  floor.shapes.push_back({.kind = SHAPE_PLANE});
  scene.bodies.push_back(floor);
  return scene;
}

BodyDescription ball(const Vector3& position, double mass) {
  BodyDescription body;
  body.position = position;
  body.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.5});
  make_solid(body, 1);
  const double scale = mass / body.mass;
  body.mass *= scale;
  for (double& moment : body.inertia) moment *= scale;
  return body;
}

class RecordedForcesOf : public testing::TestWithParam<std::tuple<const char*, u32>> {};

// A ball of 3 kg lands at 2 m/s on the ground, a ball of 2 kg hangs by a joint. What the ground gives is m (v + g t)
// over all steps, and in each step the joint carries the weight.
TEST_P(RecordedForcesOf, ALandingAndALoad) {
  const auto [precision, substeps] = GetParam();
  const TemporaryFolder folder;
  const std::string path = folder.file("run.h5");
  constexpr u32 steps = 20;
  {
    World world(ground(precision, substeps), {.device = "reference"});
    const BodyHandle falls = world.add(ball({0, 0, 0.51}, 3)), hangs = world.add(ball({5, 0, 2}, 2));
    world.add(JointDescription{.kind = JOINT_BALL, .anchor_a = {5, 0, 2}, .anchor_b = {5, 0, 2}}, hangs);
    world.set_velocity(falls, {{0, 0, -2}, {0, 0, 0}});
    world.record(path, RecordedData::motion_and_forces);
    for (u32 i = 0; i < steps; ++i) world.step();
  }
  const RecordingReader recording(path);
  ASSERT_TRUE(recording.has_forces());
  double impulse = 0;
  for (u32 row = 0; row < steps; ++row) {
    const RecordedForces forces = recording.forces(row);
    for (const ContactForceRow& contact : forces.contacts) {
      const double up = contact.body_a == 0 ? -1 : 1;
      EXPECT_EQ(contact.body_a + contact.body_b, 1u);
      EXPECT_NEAR(up * contact.normal[2], 1, 1e-6);
      EXPECT_NEAR(contact.point[2], 0, 0.02);
      impulse += up * contact.force[2] * dt;
    }
    ASSERT_EQ(forces.joints.size(), 1u);
    EXPECT_NEAR(std::abs(forces.joints[0].force[2]), 2 * gravity, 1e-3);
  }
  EXPECT_NEAR(impulse, 3 * (2 + gravity * steps * dt), 2e-3);

  u32 equal = 0;
  const StepTarget target{test_device(), {}};
  const auto count = [&](u32) { ++equal; };
  if (precision == std::string("double"))
    replay<double>(recording, target, count);
  else
    replay<float>(recording, target, count);
  EXPECT_EQ(equal, steps);
}

INSTANTIATE_TEST_SUITE_P(All, RecordedForcesOf,
                         testing::Combine(testing::Values("float", "double"), testing::Values(1u, 4u, 5u, 12u)));

// Nobody asked: no table.
TEST(RecordedForces, AreLeftOut) {
  const TemporaryFolder folder;
  {
    World world(ground("float", 2), {.device = "reference"});
    world.add(ball({0, 0, 0.5}, 1));
    world.record(folder.file("run.h5"));
    world.step();
  }
  EXPECT_FALSE(RecordingReader(folder.file("run.h5")).has_forces());
}

}  // namespace
}  // namespace lockstep::recorded_forces_test
