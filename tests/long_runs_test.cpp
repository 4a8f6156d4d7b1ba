// Runs of hours, and waiting for kernels: time is counted in steps, who waits is told, and who would rather not wait
// later builds kernels before.
#include <cmath>

#include "host/device/device.hpp"
#include "host/record/recording_reader.hpp"
#include "host/simulation.hpp"
#include "tests/command_line.hpp"
#include "tests/library_worlds.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::long_runs_test {
namespace {

// Added up in double, 1,296,000 steps of 1/60 s are off by 1e-7 s; in float by minutes.
TEST(LongRuns, SixHoursOfStepsAreSixHours) {
  for (const char* precision : {"float", "double"}) {
    World world(empty_scene(1.0 / 60), {.device = "reference", .precision = precision});
    BodyDescription hand;
    hand.kind = BODY_KINEMATIC;
    hand.angular_velocity = {0, 0, 0.1};
    const BodyHandle body = world.add(hand);
    double middle = 0;
    world.step(1'296'000);
    EXPECT_DOUBLE_EQ(world.time(), 21600);
    const Snapshot snapshot = world.save();
    // a change makes all anew, but not the clock; loads are asked for the middle of the step
    const BodyHandle ball = world.add(ball_at({9, 0, 0}));
    world.set_load(ball, [&](double time) { return middle = time, Wrench{}; });
    world.step();
    EXPECT_DOUBLE_EQ(middle, 21600 + 0.5 / 60);
    EXPECT_DOUBLE_EQ(world.time(), 21600 + 1.0 / 60);
    world.restore(snapshot);
    EXPECT_DOUBLE_EQ(world.time(), 21600);
    EXPECT_TRUE(world.contains(body));
  }
}

using LongRunsRecorded = CommandLine;

// In float a step of 1/60 s in five parts is 1.5e-9 s too long.
TEST_F(LongRunsRecorded, RecordingsHaveTheStepOfTheScene) {
  const std::string path = file("run.h5").string();
  {
    Scene scene = empty_scene(1.0 / 60);
    scene.settings.substeps = 5;
    World world(scene, {.device = "reference", .precision = "float"});
    world.add(ball_at({0, 0, 0}));
    world.record(path);
    world.step(2);
  }
  const RecordingReader recording(path);
  const StepParams<float> params = recording.start<float>().params;
  EXPECT_EQ(recording.dt(params), 1.0 / 60);
  EXPECT_NE(double(params.dt) * params.substeps, 1.0 / 60);
}

std::vector<std::string> lines_of(double patience, u32 steps, bool anew) {
  static u32 number = 0;
  std::vector<std::string> lines;
  DeviceOptions options;
  options.tell_building = [&](const std::string& line) { lines.push_back(line); };
  options.patience = patience;
  // a text that nobody has built
  if (anew)
    options.patches = {
        {"integrate_velocities.cl", "#pragma OPENCL", "// " + std::to_string(++number) + "\n#pragma OPENCL"}};
  const InitialState<float> state = compile<float>(ground_scene());
  Simulation<float> simulation(std::make_unique<DeviceBackend<float>>(state, test_device(), options), state.params);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  return lines;
}

TEST(Building, WhoWaitsLongerThanPatienceIsToldOnce) {
  const std::vector<std::string> lines = lines_of(0, 0, true);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].rfind("building kernels for ", 0), 0u) << lines[0];
  EXPECT_NE(lines[0].find(" takes a while; what is built is kept for the runs to come"), std::string::npos) << lines[0];
  EXPECT_EQ(lines_of(1e9, 3, true).size(), 0u);
  EXPECT_EQ(lines_of(0, 3, true).size(), 1u) << "kernels of the first step are the same wait";
}

TEST(Building, TheClockAddsUpAndBeginsAnewAfterwards) {
  std::vector<std::string> lines;
  BuildClock clock(
      "it", [&](const std::string& line) { lines.push_back(line); }, 0.02);
  const auto wait = [](double seconds) {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < seconds) continue;
  };
  clock.time([&] { wait(0.012); });
  clock.reset();
  clock.time([&] { wait(0.012); });
  EXPECT_EQ(lines.size(), 0u);
  clock.time([&] { wait(0.012); });
  EXPECT_EQ(lines.size(), 1u);
  clock.time([&] { wait(0.03); });
  EXPECT_EQ(lines.size(), 1u);
  clock.reset();
  clock.time([&] { wait(0.03); });
  EXPECT_EQ(lines.size(), 2u);
  BuildClock silent("it", {}, 0);
  bool done = false;
  silent.time([&] { done = true; });
  EXPECT_TRUE(done);
}

// Programs that this process has for the device, with threads and without.
std::size_t programs() {
  return open_device(test_device(), 0).programs.size() + open_device(test_device(), 1).programs.size();
}

BodyDescription drum_at(const Vector3& position) {
  BodyDescription drum;
  drum.position = position;
  drum.shapes.push_back({.kind = SHAPE_CYLINDER, .radius = 0.3, .half_length = 0.4});
  make_solid(drum, 800);
  return drum;
}

TEST(WarmUp, BuildsWhatForcesQuestionsAndBodiesToComeNeed) {
  for (const char* precision : {"float", "double"}) {
    World world(ground_scene(), {.device = "auto", .precision = precision});
    const BodyHandle box = world.add(box_at({0, 0, 0.5}));
    world.step(3);
    const std::uint64_t hash = world.state_hash();
    world.warm_up({.bodies = {drum_at({3, 0, 0.35})}});
    EXPECT_EQ(world.state_hash(), hash) << "nothing of the world has changed";
    EXPECT_EQ(world.steps_done(), 3u);
    const std::size_t built = programs();
    world.apply_force(box, {10, 0, 0}, {0, 0, 0.5});
    world.step(3);
    EXPECT_TRUE(world.cast_ray({0, 0, 5}, {0, 0, -1}));
    EXPECT_EQ(world.overlapping_sphere({0, 0, 0.5}, 0.2).size(), 1u);
    world.add(drum_at({3, 0, 0.4}));
    world.step(20);
    EXPECT_EQ(programs(), built);
  }
}

TEST(WarmUp, IsTheRunThatItIsWithout) {
  for (const char* device : {"reference", "auto"}) {
    std::uint64_t hashes[2];
    for (const bool warm : {false, true}) {
      World world(ground_scene(), {.device = device});
      const BodyHandle box = world.add(box_at({0, 0, 0.6}));
      if (warm) world.warm_up({.bodies = {ball_at({0, 0, 0.5})}});
      world.step(5);
      world.set_velocity(box, {{1, 0, 0}, {0, 0, 0}});
      world.add(ball_at({0.2, 0, 2}));
      if (warm) world.warm_up();  // with what is to be done yet
      world.step(30);
      hashes[warm] = world.state_hash();
    }
    EXPECT_EQ(hashes[0], hashes[1]);
  }
}

TEST(WarmUp, OfAWorldWithoutBodies) {
  World world(empty_scene(), {.device = "auto"});
  EXPECT_EQ(refusal([&] { world.warm_up(); }),
            "world: has no bodies to be warmed up for; add one, or say which are expected");
  world.warm_up({.bodies = {ball_at({0, 0, 0})}});
  const std::size_t built = programs();
  world.add(ball_at({0, 0, 0}));
  world.step();
  EXPECT_EQ(programs(), built);
  EXPECT_TRUE(world.cast_ray({0, 0, 5}, {0, 0, -1}));
  EXPECT_EQ(programs(), built);
  BodyDescription bad = ball_at({0, 0, 0});
  bad.mass = 0;
  EXPECT_EQ(refusal([&] { world.warm_up({.bodies = {bad}}); }),
            "body: must have a mass > 0; make_solid() gives it that of its shapes");
}

}  // namespace
}  // namespace lockstep::long_runs_test
