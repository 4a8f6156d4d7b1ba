// Checkpoints: who goes on from one ends where the whole run ends, whatever computed either part; what is no whole
// checkpoint of the scene is refused.
#include "host/record/checkpoint.hpp"

#include <gtest/gtest.h>

#include "host/record/whole_file.hpp"
#include "host/report/report.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "tests/stage_harness.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::checkpoint_test {
namespace {

using Bytes = std::vector<unsigned char>;

// What runs a part: the reference where `lanes` is 0.
template <class real>
Simulation<real> start(const InitialState<real>& state, u32 lanes = 0, u32 work_group = 0) {
  DeviceOptions options;
  options.lanes = lanes;
  options.work_group = work_group;
  std::unique_ptr<Backend<real>> backend;
  if (lanes == 0)
    backend = std::make_unique<ReferenceBackend<real>>(state);
  else
    backend = std::make_unique<DeviceBackend<real>>(state, test_device(), options);
  return Simulation<real>(std::move(backend), state.params, state.buffers.step_index.front());
}

template <class real>
std::uint64_t hash_of(Simulation<real>& simulation) {
  return combined_state_hash(simulation.world_hashes());
}

template <class real>
Bytes checkpoint_of(Simulation<real>& simulation, const std::string& scene, const SceneIdentity& identity) {
  Backend<real>& backend = simulation.backend();
  const CheckpointLabel label = {scene, backend.name(), identity, hash_of(simulation)};
  return encode_checkpoint(label, backend.download(persistent_buffers(backend.features())), backend.features());
}

template <class real>
Bytes checkpoint_after(u32 steps, const std::string& scene) {
  const InitialState<real> state = compile<real>(read_scene(scene));
  Simulation<real> simulation = start(state);
  while (simulation.steps_done() < steps) simulation.step();
  return checkpoint_of(simulation, scene, identity_of(state));
}

// Resumes after every tenth step; the parts run on the reference.
template <class real>
void expect_resume_is_exact(const std::string& name, u32 steps) {
  SCOPED_TRACE(name);
  const InitialState<real> state = compile<real>(read_scene(name));
  Simulation<real> whole = start(state);
  std::vector<Bytes> checkpoints;
  while (whole.steps_done() < steps) {
    if (whole.steps_done() % 10 == 0) checkpoints.push_back(checkpoint_of(whole, name, identity_of(state)));
    whole.step();
  }
  const std::uint64_t expected = hash_of(whole);
  for (const Bytes& bytes : checkpoints) {
    InitialState<real> resumed = state;
    const CheckpointLabel label = resume_from(bytes, "x.h5", name, resumed);
    Simulation<real> rest = start(resumed);
    EXPECT_EQ(hash_of(rest), label.state_hash);
    while (rest.steps_done() < steps) rest.step();
    EXPECT_EQ(hash_of(rest), expected) << "resumed after " << resumed.buffers.step_index.front() << " steps";
  }
}

TEST(Checkpoint, GoingOnFromAnyTenthStepEndsAlike) {
  expect_resume_is_exact<float>("spheres_small", 60);
  expect_resume_is_exact<float>("sensor_gate", 60);
  expect_resume_is_exact<float>("rover", 40);
  expect_resume_is_exact<float>("particles_slope", 20);
  expect_resume_is_exact<double>("slabs", 30);
  expect_resume_is_exact<double>("heavy_top", 50);
}

TEST(Checkpoint, GoesFromDeviceToDeviceWithAnyLaunch) {
  constexpr u32 segments = 4, steps = 15;  // of each segment
  const std::string name = "spheres_small";
  const InitialState<float> state = compile<float>(read_scene(name));
  Simulation<float> whole = start(state);
  while (whole.steps_done() < segments * steps) whole.step();

  const std::pair<u32, u32> launches[segments] = {{16, 0}, {1, 5}, {0, 0}, {8, 64}};  // lanes, work-group
  InitialState<float> current = state;
  std::uint64_t last = 0;
  for (const auto& [lanes, work_group] : launches) {
    Simulation<float> segment = start(current, lanes, work_group);
    for (u32 i = 0; i < steps; ++i) segment.step();
    last = hash_of(segment);
    current = state;
    resume_from(checkpoint_of(segment, name, identity_of(state)), "x.h5", name, current);
  }
  EXPECT_EQ(last, hash_of(whole));
}

TEST(Checkpoint, MakesRoomForWhatItContains) {
  const std::string name = "sensor_gate";
  InitialState<float> tight = compile<float>(read_scene(name));
  tight.sizes.pairs = tight.sizes.contacts = tight.params.pair_capacity = tight.params.contact_capacity = 1;
  resize(tight.buffers, tight.sizes, tight.features);
  resume_from(checkpoint_after<float>(50, name), "x.h5", name, tight);
  EXPECT_GE(tight.sizes.contacts, tight.buffers.cached_count.front());
  EXPECT_GE(tight.sizes.pairs, tight.buffers.touching_count.front());
  EXPECT_GT(tight.buffers.cached_count.front(), 1u);
  EXPECT_EQ(tight.params.contact_capacity, tight.sizes.contacts);
}

// The line that resuming is refused with.
std::string refusal(const Bytes& bytes, const std::string& scene = "spheres_small",
                    const Settings* settings = nullptr) {
  Scene read = read_scene(scene);
  if (settings) read.settings = *settings;
  InitialState<float> state = compile<float>(read);
  try {
    resume_from(bytes, "x.h5", scene, state);
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::input);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "accepted";
}

TEST(Checkpoint, OfSomethingElseIsRefused) {
  const Bytes good = checkpoint_after<float>(5, "spheres_small");
  EXPECT_EQ(refusal(good), "accepted");
  EXPECT_EQ(refusal(good, "slide_to_roll"),
            "x.h5: is a checkpoint of scene \"spheres_small\", not of \"slide_to_roll\"");
  Settings settings = read_scene("spheres_small").settings;
  settings.iterations = 11;
  EXPECT_EQ(
      refusal(good, "spheres_small", &settings),
      "x.h5: was made with other settings; give the options of that run, as --dt, --substeps, --solver or --events");
  EXPECT_EQ(refusal(checkpoint_after<double>(5, "spheres_small")), "x.h5: is in double; ask for --precision double");
}

// What a file says of itself stands in one line, whatever it is.
TEST(Checkpoint, OfASceneWithAStrangeNameIsRefusedInOneLine) {
  const InitialState<float> state = compile<float>(read_scene("sensor_gate"));
  const std::string name = "two\nlines \xff";
  const Bytes bytes =
      encode_checkpoint<float>({name, "a device", identity_of(state), 0}, state.buffers, state.features);
  EXPECT_EQ(refusal(bytes), "x.h5: is a checkpoint of scene \"two\\nlines \\ufffd\", not of \"spheres_small\"");
}

TEST(Checkpoint, OfAnotherVersionOfTheSceneIsRefused) {
  Scene scene = read_scene("spheres_small");
  scene.bodies.back().mass *= 2;
  InitialState<float> state = compile<float>(scene);
  try {
    resume_from(checkpoint_after<float>(5, "spheres_small"), "x.h5", "spheres_small", state);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "x.h5: was made of another version of scene \"spheres_small\"");
  }
}

TEST(Checkpoint, TornOrDamagedIsRefused) {
  const Bytes good = checkpoint_after<float>(5, "spheres_small");
  for (std::size_t length = 0; length < good.size(); length += 97) {
    const std::string line = refusal(Bytes(good.begin(), good.begin() + std::ptrdiff_t(length)));
    EXPECT_NE(line, "accepted") << length;
  }
  for (std::size_t at = 0; at < good.size(); at += 61) {
    Bytes damaged = good;
    damaged[at] ^= 0x10;
    EXPECT_NE(refusal(damaged), "accepted") << at;
  }
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_EQ(refusal(longer), "x.h5: has " + std::to_string(good.size() - 511) + " bytes behind its first block where " +
                                 std::to_string(good.size() - 512) + " were written; use an older checkpoint");
}

TEST(Checkpoint, ForeignFilesAreRefused) {
  const auto bytes = [](const std::string& text) { return Bytes(text.begin(), text.end()); };
  const std::string none = "x.h5: is no checkpoint; 'lockstep run --checkpoint' writes them";
  EXPECT_EQ(refusal({}), none);
  EXPECT_EQ(refusal(bytes("{\"bodies\": []}")), none);
  EXPECT_EQ(refusal(bytes("\x89HDF\r\n\x1a\n")),
            "x.h5: is no checkpoint but another HDF5 file; 'lockstep verify' reads recordings");
  EXPECT_EQ(refusal(bytes("lockstep checkpoint 1, 0 bytes")), "x.h5: is cut short; use an older checkpoint");
  EXPECT_EQ(refusal(bytes("lockstep checkpoint 7, 9" + std::string(512, ' '))),
            "x.h5: has format 7, this program reads format 1");
  EXPECT_EQ(refusal(bytes("lockstep checkpoint x" + std::string(512, ' '))),
            "x.h5: is damaged in its first line; use an older checkpoint");
}

// ---- files that are there whole or not at all --------------------------------------------------------------------

std::string refusal_of_path(const std::string& path) {
  try {
    expect_writable(path, "the checkpoint", checkpoint_signature);
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::input);
    return error.what();
  }
  return "accepted";
}

TEST(WholeFile, OnlyOurOwnAreOverwritten) {
  const TemporaryFolder folder;
  const std::string path = folder.file("x");
  EXPECT_EQ(refusal_of_path(path), "accepted");
  EXPECT_FALSE(std::filesystem::exists(path)) << "asking leaves nothing behind";
  const std::string ours = std::string(checkpoint_signature) + " 1", other = "{}";
  replace_file(path, Bytes(ours.begin(), ours.end()));
  EXPECT_EQ(refusal_of_path(path), "accepted");
  replace_file(path, Bytes(other.begin(), other.end()));
  EXPECT_EQ(refusal_of_path(path),
            path + ": is there already and is something else; the checkpoint does not overwrite it");
  EXPECT_EQ(refusal_of_path("/dev/null"), "/dev/null: the checkpoint cannot be written: it is no file");
  EXPECT_EQ(refusal_of_path("/no/such/folder/x"),
            "/no/such/folder/x: the checkpoint cannot be written: No such file or directory");
}

TEST(WholeFile, ComesBackAsItWasWritten) {
  const TemporaryFolder folder;
  const Bytes bytes = {0, 1, 2, 250, 0};
  replace_file(folder.file("x"), {});
  replace_file(folder.file("x"), bytes);
  EXPECT_EQ(read_whole_file(folder.file("x")), bytes);
  EXPECT_THROW(replace_file("/no/such/folder/x", bytes), Error);
  EXPECT_THROW(read_whole_file(folder.file("y")), Error);
  EXPECT_THROW(read_whole_file(folder.file("")), Error);
  const std::filesystem::directory_iterator files(std::filesystem::path(folder.file("x")).parent_path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1) << "no temporary file stays";
}

}  // namespace
}  // namespace lockstep::checkpoint_test
