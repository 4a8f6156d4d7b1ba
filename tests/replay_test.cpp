// Replays: a recording is verified by whatever else computes the same bits; what differs is named.
#include "host/record/replay.hpp"

#include <gtest/gtest.h>

#include "host/backends/checked_backend.hpp"
#include "tests/recording_scene.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::replay_test {
namespace {

const std::string scene = "spheres_small";
constexpr u32 steps = 40;

class ReplayTest : public testing::Test {
 protected:
  // "equal", or the line that the replay ends with.
  std::string outcome(const StepTarget& target) const {
    const RecordingReader recording(path_);
    u32 told = 0;
    try {
      const auto done = [&](u32 current) { told = current; };
      replay<float>(recording, target, done, [&](const Mismatch& mismatch, CheckedBackend<float>& backend) {
        const Difference& d = mismatch.difference();
        const Buffer wanted[] = {d.buffer};
        EXPECT_EQ(d.buffer, Buffer::motions);
        EXPECT_NE(backend.device_buffers(d, wanted).motions[d.element].v[2],
                  backend.reference_buffers().motions[d.element].v[2]);
        ++partings_;
      });
    } catch (const Error& error) {
      EXPECT_EQ(error.failure(), Failure::comparison);
      return error.what();
    }
    EXPECT_EQ(told, recording.steps());
    return "equal";
  }

  // Flips a bit of a number of the recording.
  template <class Word>
  void damage(const char* table, std::vector<hsize_t> at) const {
    const h5::Handle file(H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
    const h5::Handle dataset = h5::open_dataset(file, table), space(H5Dget_space(dataset));
    const std::vector<hsize_t> one(at.size(), 1);
    const h5::Handle memory = h5::space(one);
    h5::check(H5Sselect_hyperslab(space, H5S_SELECT_SET, at.data(), nullptr, one.data(), nullptr));
    const hid_t type = sizeof(Word) == 8 ? H5T_NATIVE_UINT64 : H5T_NATIVE_FLOAT;
    Word word = {};
    h5::check(H5Dread(dataset, type, memory, space, H5P_DEFAULT, &word));
    reinterpret_cast<unsigned char&>(word) ^= 4;
    h5::check(H5Dwrite(dataset, type, memory, space, H5P_DEFAULT, &word));
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_.file("x.h5");
  mutable int partings_ = 0;  // told of
};

DeviceOptions launch(u32 lanes, u32 work_group) {
  DeviceOptions options;
  options.lanes = lanes;
  options.work_group = work_group;
  return options;
}

// integrate_velocities with one rounding less; differs from the second step on.
DeviceOptions fused() {
  DeviceOptions options;
  options.patches = {
      {"integrate_velocities.cl", "v = add3(v, scale3(params.dt, pull));", "v.z = fma(params.dt, pull.z, v.z);"}};
  return options;
}

TEST_F(ReplayTest, EveryDeviceVerifiesEveryOther) {
  record_scene<float>(path_, scene, steps);
  EXPECT_EQ(outcome({}), "equal");
  const DeviceOptions narrow = launch(1, 3), wide = launch(16, 0);
  EXPECT_EQ(outcome({test_device(), narrow}), "equal");
  record_scene<float>(path_, scene, steps, &wide);
  EXPECT_EQ(outcome({}), "equal");
  EXPECT_EQ(outcome({test_device(), narrow}), "equal");
}

TEST_F(ReplayTest, GoesOnWhereTheRecordingBegan) {
  InitialState<double> state = compile<double>(read_scene("slide_to_roll"));
  {
    Simulation<double> first = simulation_of(state);
    for (u32 i = 0; i < 10; ++i) first.step();
    state.buffers = first.backend().download({});
  }
  Simulation<double> simulation = simulation_of(state);
  RecordingWriter<double> writer(path_, {}, state);
  for (u32 i = 0; i < 10; ++i) record_step(writer, simulation);
  writer.close("finished");
  const RecordingReader recording(path_);
  EXPECT_EQ(recording.rows().front().step, 11u);
  EXPECT_EQ(replay<double>(recording, {}, [](u32) {}).device, "reference");
}

TEST_F(ReplayTest, NamesTheStageAndTheWordOfADeviceThatDiffers) {
  record_scene<float>(path_, scene, steps);
  const std::string line = outcome({test_device(), fused()});
  EXPECT_EQ(partings_, 1);
  EXPECT_EQ(line.rfind("step ", 0), 0u) << line;
  EXPECT_NE(line.find(", integrate_velocities: motions["), std::string::npos) << line;
  EXPECT_NE(line.find("] word 2: device 0x"), std::string::npos) << line;
  EXPECT_NE(line.find(", reference 0x"), std::string::npos) << line;
}

// Where the replay is right and the recording was made by something else.
TEST_F(ReplayTest, NamesTheWordOfARecordingThatDiffers) {
  const DeviceOptions wrong = fused();
  record_scene<float>(path_, scene, steps, &wrong);
  const std::string line = outcome({});
  EXPECT_EQ(line.rfind("step ", 0), 0u) << line;
  EXPECT_NE(line.find("] word "), std::string::npos) << line;
  EXPECT_NE(line.find(": recorded 0x"), std::string::npos) << line;
  EXPECT_NE(line.find(", here 0x"), std::string::npos) << line;
  EXPECT_NE(line.find("look at what recorded it: \"a device\\nin two lines\", version"), std::string::npos) << line;
}

TEST_F(ReplayTest, NamesAFlippedHash) {
  record_scene<float>(path_, scene, steps);
  damage<std::uint64_t>("state_hashes", {17, 0});
  const std::string line = outcome({});
  EXPECT_EQ(line.rfind("step 17: the state hash of world 0 was recorded as ", 0), 0u) << line;
  EXPECT_NE(line.find("poses and velocities are equal"), std::string::npos) << line;
}

TEST_F(ReplayTest, NamesBothVersionsOfARecordingThatDiffers) {
  record_scene<float>(path_, scene, steps);
  damage<std::uint64_t>("state_hashes", {17, 0});
  {
    const h5::Handle file(H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
    h5::check(H5Adelete(file, "version"));
    h5::write_attribute(file, "version", std::string("0.0.9"));
  }
  const std::string line = outcome({});
  EXPECT_NE(line.find("recorded by version 0.0.9, replayed by version "), std::string::npos) << line;
  EXPECT_EQ(line.find("look at what recorded it"), std::string::npos) << line;
}

TEST_F(ReplayTest, NamesAFlippedPose) {
  record_scene<float>(path_, scene, steps);
  damage<std::uint64_t>("pose_hashes", {23, 0});
  damage<float>("orientations", {23, 5, 3});
  const std::string line = outcome({});
  EXPECT_EQ(line.rfind("step 23: orientations[5] word 3: recorded 0x", 0), 0u) << line;
}

}  // namespace
}  // namespace lockstep::replay_test
