// Recordings of worlds that go back: they note it, and are replayed with every hash equal.
#include <filesystem>

#include "host/record/recording_tables.hpp"
#include "host/record/replay.hpp"
#include "tests/command_line.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::snapshot_recording_test {
namespace {

class SnapshotRecording : public CommandLine {
 protected:
  std::string path(int number = 1) const {
    return file(number == 1 ? "run.h5" : "run." + std::to_string(number) + ".h5").string();
  }

  template <class real>
  u32 restores_replayed(int number, const StepTarget& target) const {
    const RecordingReader recording(path(number));
    u32 steps = 0;
    replay<real>(recording, target, [&](u32) { ++steps; });
    EXPECT_EQ(steps, recording.steps());
    return static_cast<u32>(std::ranges::count(recording.inputs(), InputKind::restore, &InputRow::kind));
  }

  void expect_verified(int number = 1) const {
    for (const char* device : {"reference", "auto"}) {
      const Outcome outcome = run("verify " + path(number) + " --device " + device);
      EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
    }
  }

  // Changes a row of `inputs` of the first file.
  void change_input(std::size_t row, const std::function<void(InputRow&)>& change) const {
    const h5::Handle opened(H5Fopen(path().c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
    const h5::Handle table = h5::open_dataset(opened, "inputs"), type = input_row_type();
    std::vector<InputRow> rows(h5::extent_of(table)[0]);
    h5::check(H5Dread(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()));
    change(rows.at(row));
    h5::check(H5Dwrite(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()));
  }
};

Scene sleepy_ground() {
  Scene scene = ground_scene();
  scene.settings.sleeping = SleepSettings{.after = 0.1};
  scene.settings.loads = true;
  return scene;
}

// Loads, motors and blows before and after snapshots, between two steps and at once after another restore.
void life(World& world, const std::string& path) {
  const BodyHandle box = world.add(box_at({0, 0, 0.6})), ball = world.add(ball_at({0.1, 0, 1.7}));
  const BodyHandle wheel = world.add(ball_at({5, 0, 3}));
  const JointHandle axle = world.add(
      {.name = "axle", .kind = JOINT_HINGE, .anchor_a = {5, 0, 3}, .anchor_b = {5, 0, 3}, .axis = {0, 1, 0}}, wheel);
  world.step(7);
  world.record(path);
  const Snapshot start = world.save();
  world.set_load(box, [](double time) { return Wrench{{3 * time, 0, 0}, {0, 0, 0}}; });
  world.step(3);
  world.set_velocity(ball, {{1, 0, 0}, {0, 2, 0}});
  const Snapshot pushed = world.save();
  world.set_motor(axle, 4, 300);
  world.apply_impulse(box, {0, 3, 0});
  world.step(5);
  world.restore(pushed);  // neither the motor nor the impulse
  world.apply_force(ball, {0, 0, 50}, {0, 0, 2});
  world.step(2);
  const Snapshot forced = world.save();
  world.step(4);
  world.restore(start);
  world.restore(forced);  // nothing between
  world.set_motor(axle, -2, 100);
  world.step(2);
  world.restore(start);
  world.step(60);  // and falls asleep
  world.restore(pushed);
  world.step(3);
  world.restore(start);  // no step follows
  world.end_recording();
}

TEST_F(SnapshotRecording, IsReplayedWithEveryHashEqual) {
  for (const char* device : {"reference", "cpu"}) {
    for (const char* precision : {"float", "double"}) {
      SCOPED_TRACE(std::string(device) + ", " + precision);
      {
        World world(sleepy_ground(), {.device = device, .precision = precision});
        life(world, path());
      }
      EXPECT_FALSE(fs::exists(path(2))) << "one file has it all";
      const RecordingReader recording(path());
      EXPECT_EQ(recording.outcome(), "finished");
      const std::vector<StepRow>& rows = recording.rows();
      ASSERT_EQ(rows.size(), 3u + 5 + 2 + 4 + 2 + 60 + 3);
      EXPECT_EQ(rows[7].step, 15u);
      EXPECT_EQ(rows[8].step, 11u) << "back by five";
      EXPECT_EQ(rows[14].step, 13u);
      EXPECT_EQ(rows[16].step, 8u);
      EXPECT_EQ(rows[76].step, 11u);
      const auto count = [&](const StepTarget& target) {
        return std::string(precision) == "float" ? restores_replayed<float>(1, target)
                                                 : restores_replayed<double>(1, target);
      };
      EXPECT_EQ(count({}), 5u);  // the last one has no step
      StepTarget lanes = {select_device("cpu"), {}};
      lanes.options.lanes = 8;
      EXPECT_EQ(count(lanes), 5u);
      expect_verified();
    }
  }
}

TEST_F(SnapshotRecording, OfEightKeptOverTwentyStepsIsReplayed) {
  {
    World world(ground_scene(), {.device = "auto"});
    for (int i = 0; i < 5; ++i) world.add(box_at({0.05 * i, 0, 0.5 + 1.01 * i}));
    world.record(path());
    std::vector<Snapshot> kept;
    for (u32 step = 0; step < 20; ++step) {
      if (step >= 12) kept.push_back(world.save());
      world.step();
    }
    const std::uint64_t end = world.state_hash();
    for (u32 k = 0; k < 8; ++k) {
      world.restore(kept[k]);
      world.step(8 - k);
      EXPECT_EQ(world.state_hash(), end);
    }
  }
  EXPECT_EQ(RecordingReader(path()).steps(), 20u + 36);
  EXPECT_EQ(RecordingReader(path()).inputs().size(), 8u) << "snapshots themselves are not noted";
  expect_verified();
}

// A file is of the same bodies throughout, and knows no state from before it.
TEST_F(SnapshotRecording, GoesOnInAnotherFileWhereTheStateIsNoneOfThisOne) {
  {
    World world(ground_scene(), {.device = "reference"});
    const BodyHandle box = world.add(box_at({0, 0, 0.6}));
    world.step(3);
    const Snapshot before = world.save();
    world.step(2);
    world.record(path());
    world.step(4);  // 1
    world.restore(before);
    world.step(3);  // 2
    const Snapshot with = world.save();
    world.remove(box);
    world.add(ball_at({0, 0, 1}));
    world.step(2);  // 3
    world.restore(with);
    world.step(5);  // 4, with the engine of the second file
    const Snapshot inside = world.save();
    world.step(1);
    world.restore(inside);
    world.step(2);
  }
  for (int number = 1; number <= 4; ++number) expect_verified(number);
  EXPECT_FALSE(fs::exists(path(5)));
  EXPECT_EQ(RecordingReader(path(2)).rows()[0].step, 4u);
  EXPECT_EQ(RecordingReader(path(4)).rows()[0].step, 7u);
  EXPECT_EQ(RecordingReader(path(4)).steps(), 8u);
  EXPECT_EQ(restores_replayed<float>(4, {}), 1u);
}

TEST_F(SnapshotRecording, GoesOnAfterAStepThatFailed) {
  {
    World world(ground_scene(), {.device = "reference"});
    const BodyHandle box = world.add(box_at({0, 0, 0.6}));
    world.record(path());
    world.step(3);
    const Snapshot snapshot = world.save();
    world.set_velocity(box, {{2e5, 0, 0}, {0, 0, 0}});
    EXPECT_THROW(world.step(), Error);
    world.restore(snapshot);
    world.step(4);
  }
  EXPECT_NE(RecordingReader(path()).outcome().find("speed_limit"), std::string::npos);
  expect_verified(1);
  expect_verified(2);
  EXPECT_EQ(RecordingReader(path(2)).rows()[0].step, 4u);
}

TEST_F(SnapshotRecording, RestoresOfNoMomentBeforeThemAreRefused) {
  {
    World world(sleepy_ground(), {.device = "reference", .precision = "float"});
    life(world, path());
  }
  const std::vector<InputRow> inputs = RecordingReader(path()).inputs();
  const auto found = std::ranges::find(inputs, InputKind::restore, &InputRow::kind);
  const auto row = static_cast<std::size_t>(found - inputs.begin());
  const std::string line =
      path() + ": is no recording that this program reads: inputs[" + std::to_string(row) + "] makes no sense";
  const auto expect_refused_with = [&](const std::function<void(InputRow&)>& change) {
    change_input(row, change);
    EXPECT_EQ(refusal([&] { RecordingReader(path()).start<float>(); }), line);
    change_input(row, [&](InputRow& back) { back = *found; });
  };
  expect_refused_with([](InputRow& restore) { restore.body = 90; });
  expect_refused_with([](InputRow& restore) { restore.linear[0] = 1e9; });
  expect_refused_with([](InputRow& restore) { restore.linear[0] = -1; });
  expect_refused_with([](InputRow& restore) { restore.linear[0] += 0.5; });
  change_input(row, [](InputRow& restore) { restore.body = 0; });
  EXPECT_EQ(refusal([&] { RecordingReader{path()}; }),
            path() + ": is no recording that this program reads: steps[8] does not follow the one before it");
  change_input(row, [&](InputRow& back) { back = *found; });
  EXPECT_EQ(restores_replayed<float>(1, {}), 5u);
  // to another moment that there was
  change_input(row, [](InputRow& restore) { restore.linear[0] -= 1; });
  EXPECT_THROW(restores_replayed<float>(1, {}), Error);
}

}  // namespace
}  // namespace lockstep::snapshot_recording_test
