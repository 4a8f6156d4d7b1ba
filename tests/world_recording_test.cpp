// Recordings of a world that is acted upon: what was done is in them, so that they can be replayed anywhere.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "host/record/recording_tables.hpp"
#include "host/record/replay.hpp"
#include "include/lockstep/world.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::world_recording_test {
namespace {

BodyDescription solid(const Vector3& position, const ShapeDescription& shape) {
  BodyDescription body;
  body.position = position;
  body.shapes.push_back(shape);
  make_solid(body, 500);
  return body;
}

BodyDescription ball_at(const Vector3& position) { return solid(position, {.kind = SHAPE_SPHERE, .radius = 0.3}); }
BodyDescription box_at(const Vector3& position) {
  return solid(position, {.kind = SHAPE_BOX, .half_extents = {0.3, 0.3, 0.3}});
}

Scene ground() {
  Scene scene;
  scene.name = scene.source = "ground";
  scene.settings.dt = 0.01;
  replace_solver(scene.settings, Solver::small_steps);
  BodyDescription floor;
  floor.kind = BODY_STATIC;
  floor.shapes.push_back({.kind = SHAPE_PLANE});
  scene.bodies.push_back(floor);
  return scene;
}

// Everything that can be done to a world, in 30 steps; bodies come in step 12 and go in step 20, a joint comes in step
// 25, the first force acts in step 6.
std::uint64_t busy_life(const WorldOptions& options, const std::string& path) {
  World world(ground(), options);
  const BodyHandle box = world.add(box_at({0, 0, 0.3})), ball = world.add(ball_at({2, 0, 0.3}));
  BodyDescription lift = box_at({4, 0, 0.3});
  lift.kind = BODY_KINEMATIC, lift.mass = 0, lift.inertia = {0, 0, 0};
  const BodyHandle platform = world.add(lift);
  if (!path.empty()) world.record(path);
  for (int i = 0; i < 30; ++i) {
    if (i == 2) world.set_velocity(ball, {{1, 0, 0}, {0, 3, 0}});
    if (i == 4) world.apply_impulse(box, {10, 3, 20}, exact::add(world.pose(box).position, {0.1, 0, 0.2}));
    if (i == 6)
      world.set_load(box, [](double t) -> Wrench { return {.force = {3000 * t, 0, 0}, .torque = {0, 1, t}}; });
    if (i == 8) world.apply_force(ball, {0, 100, 0}, {2, 0, 0.5});
    if (i == 12) world.add(ball_at({0, 2, 1}));
    if (i == 16) world.set_load(box, {});
    if (i == 20) world.remove(ball);
    if (i == 25) world.add(JointDescription{.kind = JOINT_BALL, .anchor_a = {4, 0, 2}, .anchor_b = {4, 0, 2}}, box);
    world.set_kinematic_target(platform, {{4 - 0.01 * i, 0, 0.3}, {0, 0, std::sin(0.01 * i), std::cos(0.01 * i)}});
    world.step();
  }
  return world.state_hash();
}

class WorldRecording : public testing::Test {
 protected:
  std::string file(int number) const {
    return folder_.file(number == 1 ? "run.h5" : "run." + std::to_string(number) + ".h5");
  }

  template <class real>
  void expect_replays(int number, u32 first_step, u32 steps, const StepTarget& target) const {
    SCOPED_TRACE(number);
    const RecordingReader recording(file(number));
    EXPECT_EQ(recording.outcome(), number == 5 ? "stopped" : "finished");
    ASSERT_EQ(recording.steps(), steps);
    EXPECT_EQ(recording.rows()[0].step, first_step);
    u32 replayed = 0;
    replay<real>(recording, target, [&](u32) { ++replayed; });
    EXPECT_EQ(replayed, steps);
  }

  template <class real>
  void expect_replays_all(const StepTarget& target) const {
    expect_replays<real>(1, 1, 6, target);   // the first force
    expect_replays<real>(2, 7, 6, target);   // a body comes
    expect_replays<real>(3, 13, 8, target);  // a body goes
    expect_replays<real>(4, 21, 5, target);  // a joint comes
    expect_replays<real>(5, 26, 5, target);
    EXPECT_FALSE(std::filesystem::exists(file(6)));
  }

  // Changes a row of `inputs` of the first file.
  void change_input(std::size_t row, const std::function<void(InputRow&)>& change) const {
    const h5::Handle opened(H5Fopen(file(1).c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
    const h5::Handle table = h5::open_dataset(opened, "inputs"), type = input_row_type();
    std::vector<InputRow> rows(h5::extent_of(table)[0]);
    h5::check(H5Dread(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()));
    change(rows.at(row));
    h5::check(H5Dwrite(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()));
  }

  // The replay of the first file does not go through, and says so in a line that begins like this.
  void expect_divergence(const std::string& begin) const {
    try {
      replay<float>(RecordingReader(file(1)), {}, [](u32) {});
      ADD_FAILURE() << "replayed";
    } catch (const Error& error) {
      EXPECT_EQ(error.failure(), Failure::comparison);
      EXPECT_TRUE(std::string(error.what()).starts_with(begin)) << error.what();
    }
  }

  std::string refusal() const {
    try {
      RecordingReader(file(1)).start<float>();
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  }

  const TemporaryFolder folder_;
};

TEST_F(WorldRecording, ReplaysOnTheReferenceAndChangesNothing) {
  const WorldOptions reference = {.device = "reference", .precision = "float"};
  EXPECT_EQ(busy_life(reference, file(1)), busy_life(reference, ""));
  expect_replays_all<float>({});
}

TEST_F(WorldRecording, ReplaysOnAnotherDeviceThanItsOwnOnTheDevice) {
  busy_life({.device = "reference", .precision = "double"}, file(1));
  StepTarget device = {select_device("cpu"), {}};
  device.options.lanes = 8;
  expect_replays_all<double>(device);
  busy_life({.device = "cpu", .precision = "float"}, file(1));
  expect_replays_all<float>({});
}

// A velocity of before step 3, given another value: the replay parts there, and says what is another.
TEST_F(WorldRecording, WithAnotherInputHasAnotherRun) {
  busy_life({.device = "reference", .precision = "float"}, file(1));
  const std::vector<InputRow> inputs = RecordingReader(file(1)).inputs();
  const auto is_the_ball = [](const InputRow& row) { return row.body == 2 && row.step == 3; };
  const auto ball = std::find_if(inputs.begin(), inputs.end(), is_the_ball);
  ASSERT_NE(ball, inputs.end());
  EXPECT_EQ(ball->kind, InputKind::velocity);
  EXPECT_EQ(ball->linear[0], 1);
  EXPECT_EQ(ball->angular[1], 3);
  change_input(static_cast<std::size_t>(ball - inputs.begin()), [](InputRow& row) { row.linear[0] = 1.5; });
  expect_divergence("step 2: positions[2] word 0: recorded ");
}

TEST_F(WorldRecording, RefusesInvalidInputs) {
  busy_life({.device = "reference", .precision = "float"}, file(1));
  EXPECT_EQ(refusal(), "accepted");
  const std::string unreadable = file(1) + ": is no recording that this program reads: ";
  change_input(1, [](InputRow& row) { row.body = 4; });
  EXPECT_EQ(refusal(), unreadable + "inputs are of another scene");
  change_input(1, [](InputRow& row) { row.body = 1, row.kind = InputKind::load; });  // the first force comes later
  EXPECT_EQ(refusal(), unreadable + "inputs are of another scene");
  change_input(1, [](InputRow& row) { row.kind = InputKind::motor; });  // there is no joint
  EXPECT_EQ(refusal(), unreadable + "inputs are of another scene");
  change_input(1, [](InputRow& row) { row.kind = InputKind::gravity; });  // there is one world, 0
  EXPECT_EQ(refusal(), unreadable + "inputs are of another scene");
  change_input(1, [](InputRow& row) { row.kind = static_cast<InputKind>(7); });
  EXPECT_EQ(refusal(), unreadable + "inputs[1] makes no sense");
  change_input(1, [](InputRow& row) { row.kind = InputKind::velocity, row.angular[2] = std::nan(""); });
  EXPECT_EQ(refusal(), unreadable + "inputs[1] makes no sense");
  change_input(1, [](InputRow& row) { row.angular[2] = 0, row.step = 6; });
  EXPECT_EQ(refusal(), unreadable + "inputs[1] makes no sense");
}

TEST_F(WorldRecording, EndsWhereAskedToAndLeavesOtherFilesAlone) {
  World world(ground(), {.device = "reference"});
  const BodyHandle box = world.add(box_at({0, 0, 1}));
  world.record(file(1));
  world.step(2);
  world.end_recording();
  world.apply_impulse(box, {1, 0, 0});
  world.step(3);
  EXPECT_EQ(RecordingReader(file(1)).steps(), 2u);
  const std::string letter = folder_.file("letter.txt");
  std::ofstream(letter) << "dear reader";
  EXPECT_THROW(world.record(letter), Error);
  EXPECT_THROW(world.record(folder_.file("no/run.h5")), Error);
  EXPECT_THROW(world.record(""), Error);
  world.record(file(1));  // again, from the sixth step on
  world.step();
  world.end_recording();
  EXPECT_EQ(RecordingReader(file(1)).rows()[0].step, 6u);
}

// A motor that is driven otherwise before steps 4 and 8, and a body that comes before step 12.
std::uint64_t steered_life(const WorldOptions& options, const std::string& path) {
  World world(ground(), options);
  const BodyHandle box = world.add(box_at({0, 0, 2}));
  const JointHandle axle =
      world.add(JointDescription{.kind = JOINT_HINGE, .anchor_a = {0, 0, 2}, .anchor_b = {0, 0, 2}}, box);
  world.record(path);
  for (int i = 0; i < 14; ++i) {
    if (i == 3) world.set_motor(axle, 5, 2000);
    if (i == 7) world.set_motor(axle, -1, 10000);
    if (i == 11) world.add(ball_at({0, 2, 1}));
    world.step();
  }
  EXPECT_GT(std::abs(world.velocity(box).angular[2]), 0.5);
  return world.state_hash();
}

TEST_F(WorldRecording, KnowsHowMotorsAreDriven) {
  steered_life({.device = "reference", .precision = "float"}, file(1));
  const std::vector<InputRow> inputs = RecordingReader(file(1)).inputs();
  ASSERT_EQ(inputs.size(), 2u);
  EXPECT_EQ(inputs[0].kind, InputKind::motor);
  EXPECT_EQ(inputs[0].step, 4u);
  EXPECT_EQ(inputs[0].linear[0], 5);
  EXPECT_EQ(inputs[1].linear[1], 10000);
  const auto replay_both = [&](const StepTarget& target) {
    for (int number : {1, 2}) replay<float>(RecordingReader(file(number)), target, [](u32) {});
  };
  replay_both({});
  replay_both({select_device("cpu"), {}});
  change_input(1, [](InputRow& row) { row.linear[0] = -1.5; });
  expect_divergence("step 7: ");
  change_input(1, [](InputRow& row) { row.linear[1] = -1; });
  EXPECT_EQ(refusal(), file(1) + ": is no recording that this program reads: inputs are of another scene");
}

// More inputs than a chunk holds, in batches of steps.
TEST_F(WorldRecording, StoresManyInputs) {
  {
    World world(ground(), {.device = "reference", .precision = "float"});
    std::vector<BodyHandle> balls;
    for (int i = 0; i < 20; ++i) balls.push_back(world.add(ball_at({double(i), 0, 0.3})));
    for (std::size_t i = 0; i < balls.size(); ++i)
      world.set_load(balls[i], [i](double t) -> Wrench { return {.force = {0, std::sin(10 * t + double(i)), 0}}; });
    world.record(file(1));
    world.step(100);
  }
  const RecordingReader recording(file(1));
  EXPECT_EQ(recording.steps(), 100u);
  EXPECT_EQ(recording.inputs().size(), 2000u);
  replay<float>(recording, {}, [](u32) {});
}

}  // namespace
}  // namespace lockstep::world_recording_test
