// Recordings: what was written comes back, whole, while it is written and after the writer was killed.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "host/record/chunks.hpp"
#include "host/record/recording_reader.hpp"
#include "host/report/report.hpp"
#include "host/world_hash.hpp"
#include "tests/child_program.hpp"
#include "tests/recording_scene.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::recording_test {
namespace {

// ---- chunks --------------------------------------------------------------------------------------------------------

// Writes rows of u32 with GrowingRows and reads them with HDF5's own filters.
void expect_rows_come_back(const std::vector<u32>& words, std::vector<hsize_t> row, hsize_t rows_per_chunk) {
  const TemporaryFolder folder;
  std::size_t row_words = 1;
  for (const hsize_t n : row) row_words *= n;
  const h5::Handle file(H5Fcreate(folder.file("x.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  const std::size_t rows = words.size() / row_words;
  {
    GrowingRows table(file, "x", H5T_STD_U32LE, row, rows_per_chunk);
    ChunkPacker packer;
    for (std::size_t i = 0; i < rows; i += rows_per_chunk)
      table.append(words.data() + i * row_words, std::min<hsize_t>(rows_per_chunk, rows - i), packer);
  }
  const h5::Handle dataset = h5::open_dataset(file, "x");
  std::vector<hsize_t> extent = {rows};
  extent.insert(extent.end(), row.begin(), row.end());
  EXPECT_EQ(h5::extent_of(dataset), extent);
  std::vector<u32> back(words.size());
  h5::check(H5Dread(dataset, H5T_NATIVE_UINT32, H5S_ALL, H5S_ALL, H5P_DEFAULT, back.data()));
  EXPECT_EQ(back, words);
}

TEST(Chunks, AreWhatTheFiltersOfHdf5Make) {
  std::mt19937 random(1);
  std::vector<u32> noise(3 * 7 * 5000), repeating(3 * 7 * 5000);
  for (std::size_t i = 0; i < noise.size(); ++i) {
    noise[i] = static_cast<u32>(random()) & 0x0fffffffu;
    repeating[i] = static_cast<u32>(i % 15000);
  }
  for (const auto& words : {noise, repeating}) {
    expect_rows_come_back(words, {5000, 3}, 7);       // one batch, in parts
    expect_rows_come_back(words, {5000, 3}, 4);       // two, the second not full
    expect_rows_come_back(words, {7, 3}, 64);         // short rows
    expect_rows_come_back(words, {}, 1000);           // no rows but numbers
    expect_rows_come_back(words, {3 * 7 * 5000}, 1);  // a long one
  }
}

// What only rests is deflated whole: a thousand rows of the same take next to nothing.
TEST(Chunks, WhatRepeatsTakesLittleRoom) {
  std::vector<unsigned char> rows(64 * 4096);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<unsigned char>(i % 4096 * 37);
  ChunkPacker packer;
  EXPECT_LT(packer.pack(rows, 4, 1024).size(), rows.size() / 20);
}

// ---- a recording ---------------------------------------------------------------------------------------------------

template <class real>
void expect_recording_comes_back(const std::string& scene, u32 steps) {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.h5");
  record_scene<real>(path, scene, steps);
  const RecordingReader recording(path);
  EXPECT_EQ(recording.label().scene, scene);
  EXPECT_EQ(recording.label().scene_text, read_scene(scene).text);
  EXPECT_EQ(recording.outcome(), "finished");
  EXPECT_EQ(recording.precision(), sizeof(real) == 8 ? "double" : "float");
  ASSERT_EQ(recording.steps(), steps);

  // the true run, from what the recording says it began with
  Simulation<real> simulation = simulation_of(recording.start<real>());
  for (u32 row = 0; row < steps; ++row) {
    simulation.step();
    EXPECT_EQ(recording.state_hashes()[row], state_hash(simulation.world_hashes()[0]));
    EXPECT_EQ(recording.rows()[row].step, row + 1);
    EXPECT_EQ(recording.rows()[row].contacts, simulation.counters()[COUNTER_CONTACTS]);
    const Buffers<real>& current = simulation.backend().download(RecordingWriter<real>::wanted());
    const std::vector<real> positions = recording.bodies<real>(0, row),
                            angular_velocities = recording.bodies<real>(3, row);
    ASSERT_EQ(positions.size(), 3 * current.positions.size());
    for (std::size_t i = 0; i < current.positions.size(); ++i) {
      EXPECT_EQ(positions[3 * i + 2], current.positions[i].z);
      EXPECT_EQ(angular_velocities[3 * i + 1], current.motions[i].w[1]);
    }
  }
}

TEST(Recording, ComesBack) {
  expect_recording_comes_back<float>("spheres_small", 70);  // two batches
  expect_recording_comes_back<float>("rover", 5);
  expect_recording_comes_back<double>("sensor_gate", 64);
}

TEST(Recording, HasARowOfHashesForEachWorld) {
  const TemporaryFolder folder;
  const std::vector<Scene> worlds = {read_scene("slide_to_roll"), read_scene("spheres_small")};
  const InitialState<float> state = compile<float>(worlds);
  Simulation<float> simulation = simulation_of(state);
  RecordingWriter<float> writer(folder.file("x.h5"), {}, state);
  for (int i = 0; i < 3; ++i) record_step(writer, simulation);
  writer.close("finished");
  const RecordingReader recording(folder.file("x.h5"));
  const std::vector<WorldHash> hashes = simulation.world_hashes();
  ASSERT_EQ(recording.state_hashes().size(), 6u);
  EXPECT_EQ(recording.state_hashes()[4], state_hash(hashes[0]));
  EXPECT_EQ(recording.state_hashes()[5], state_hash(hashes[1]));
  EXPECT_EQ(recording.start<float>().sizes.worlds, 2u);
}

TEST(Recording, CanBeReadWhileItIsWritten) {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.h5"), report = folder.file("x.json");
  ChildProgram program({"run", "spheres_small", "--steps", "1000000", "--quiet", "--device", "reference", "--record",
                        path, "--report", report});
  while (!std::filesystem::exists(path)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::vector<std::uint64_t> seen;
  for (u32 grown = 0; grown < 5;) {
    const RecordingReader recording(path);
    EXPECT_EQ(recording.outcome(), "running");
    const std::vector<std::uint64_t>& hashes = recording.state_hashes();
    ASSERT_GE(hashes.size(), seen.size());
    EXPECT_TRUE(std::equal(seen.begin(), seen.end(), hashes.begin()));
    grown += hashes.size() > seen.size();
    seen = hashes;
  }
  // Ctrl-C
  const int status = program.end(SIGINT);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 128 + SIGINT) << status;
  const RecordingReader recording(path);
  EXPECT_EQ(recording.outcome(), "interrupted");
  const auto json = nlohmann::json::parse(std::ifstream(report));
  EXPECT_EQ(json["interrupted"], true);
  EXPECT_EQ(json["steps"], recording.steps());
  EXPECT_EQ(json["state_hash"], hash_text(recording.state_hashes().back()));
}

TEST(Recording, CannotBeMade) {
  const TemporaryFolder folder;
  const InitialState<float> state = compile<float>(read_scene("slide_to_roll"));
  EXPECT_THROW(RecordingWriter<float>(folder.file("no/x.h5"), {}, state), Error);
  const std::string path = folder.file(std::string(252, 'x'));  // the name of an unfinished file is longer
  EXPECT_THROW(RecordingWriter<float>(path, {}, state), Error);
  EXPECT_FALSE(std::filesystem::exists(path));
}

// ---- killed --------------------------------------------------------------------------------------------------------

// Each is killed at a random moment after its recording was begun. LOCKSTEP_KILLS=50 kills as many,
// LOCKSTEP_KILL_DEVICE=cpu on another device than the reference.
TEST(Recording, IsAPrefixOfTheRunAfterAKillAtAnyMoment) {
  const char *kills = std::getenv("LOCKSTEP_KILLS"), *device = std::getenv("LOCKSTEP_KILL_DEVICE");
  const int rounds = kills ? std::atoi(kills) : 6;
  std::mt19937 random(7);
  Simulation<float> truth = simulation_of(compile<float>(read_scene("spheres_small")));
  std::vector<std::uint64_t> hashes;
  int with_steps = 0;
  for (int round = 0; round < rounds; ++round) {
    const TemporaryFolder folder;
    const std::string path = folder.file("x.h5");
    ChildProgram program({"run", "spheres_small", "--steps", "1000000", "--quiet", "--device",
                          device ? device : "reference", "--record", path});
    while (!std::filesystem::exists(path)) {
      ASSERT_TRUE(program.runs()) << "it ended before its recording was begun";
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 700));
    EXPECT_TRUE(WIFSIGNALED(program.end(SIGKILL))) << "it ended before it was killed";
    const RecordingReader recording(path);
    EXPECT_EQ(recording.outcome(), "running");
    EXPECT_EQ(recording.start<float>().sizes.bodies, truth.backend().sizes().bodies);
    while (hashes.size() < recording.steps()) {
      truth.step();
      hashes.push_back(state_hash(truth.world_hashes()[0]));
    }
    for (u32 i = 0; i < recording.steps(); ++i) ASSERT_EQ(recording.state_hashes()[i], hashes[i]) << "step " << i;
    if (recording.steps() == 0) continue;
    ++with_steps;
    for (u32 table = 0; table < 4; ++table)
      EXPECT_GT(recording.bodies<float>(table, recording.steps() - 1).size(), 0u) << table;
  }
  EXPECT_GE(with_steps, rounds / 2);
  std::printf("%d kills, %d with steps, %zu at most\n", rounds, with_steps, hashes.size());
}

}  // namespace
}  // namespace lockstep::recording_test
