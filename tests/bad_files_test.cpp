// Recordings that are none, torn, foreign or changed: each is refused with one line that names the file.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "host/record/checkpoint.hpp"
#include "host/record/recording_reader.hpp"
#include "host/record/whole_file.hpp"
#include "tests/recording_scene.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::bad_files_test {
namespace {

using Bytes = std::vector<unsigned char>;

const Bytes& good_recording() {
  static const Bytes bytes = [] {
    const TemporaryFolder folder;
    record_scene<float>(folder.file("x.h5"), "spheres_small", 5);
    return read_whole_file(folder.file("x.h5"));
  }();
  return bytes;
}

// What reading says, the folder of the file left out; "accepted" where it says nothing.
std::string refusal(const TemporaryFolder& folder, const std::string& path) {
  try {
    const RecordingReader recording(path);
    recording.start<float>();
    for (u32 table = 0; table < 4; ++table) recording.bodies<float>(table, 0);
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::input);
    std::string line = error.what();
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    const std::string name = folder.file("");
    if (line.rfind(name, 0) == 0) line.erase(0, name.size());
    return line;
  }
  return "accepted";
}

std::string refusal_of(const Bytes& bytes) {
  const TemporaryFolder folder;
  replace_file(folder.file("x.h5"), bytes);
  return refusal(folder, folder.file("x.h5"));
}

// What reading says of a good recording after a change.
std::string refusal_after(const std::function<void(hid_t file)>& change) {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.h5");
  replace_file(path, good_recording());
  {
    const h5::Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
    change(file);
  }
  return refusal(folder, path);
}

const std::string unreadable = "x.h5: is no recording that this program reads: ";

TEST(BadRecordings, AGoodOneIsAccepted) { EXPECT_EQ(refusal_of(good_recording()), "accepted"); }

TEST(BadRecordings, WhatIsNoFileOfHdf5IsRefused) {
  const TemporaryFolder folder;
  EXPECT_EQ(refusal(folder, folder.file("none.h5")), "none.h5: no such file");
  EXPECT_EQ(refusal(folder, "/"), "/: is a directory, must be a recording");
  EXPECT_EQ(refusal(folder, folder.file("../../../../nowhere/x.h5")), "../../../../nowhere/x.h5: no such file");
  const auto text = [](const std::string& words) { return refusal_of(Bytes(words.begin(), words.end())); };
  for (const std::string words : {"", "x", "{\"bodies\": []}", "lockstep checkpoint 1, 5 bytes, hash 0\n",
                                  "\x89PNG\r\n\x1a\n", "\x89HDF\r\n\x1a\n"})
    EXPECT_EQ(text(words).rfind(unreadable, 0), 0u) << words;
  EXPECT_EQ(text(std::string(100000, '[')).rfind(unreadable, 0), 0u);
  std::string empty_inside = "\x89HDF\r\n\x1a\n";
  empty_inside.append(5000, '\0');
  EXPECT_EQ(text(empty_inside).rfind(unreadable, 0), 0u);
}

TEST(BadRecordings, TornOnesAreRefused) {
  const Bytes& good = good_recording();
  for (std::size_t length = 0; length < good.size(); length += 499) {
    const std::string line = refusal_of(Bytes(good.begin(), good.begin() + std::ptrdiff_t(length)));
    EXPECT_EQ(line.rfind(unreadable, 0), 0u) << length << " of " << good.size() << " bytes: " << line;
  }
}

// Random bytes changed: refused, or somewhere that does not matter; never a crash.
TEST(BadRecordings, DamagedOnesDoNotCrash) {
  std::mt19937 random(3);
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    Bytes damaged = good_recording();
    for (int k = 0; k < 4; ++k) damaged[random() % damaged.size()] ^= static_cast<unsigned char>(1 + random() % 255);
    refused += refusal_of(damaged) != "accepted";
  }
  EXPECT_GT(refused, 100);
}

struct Change {
  const char* what;
  std::function<void(hid_t)> change;
  std::string line;
};

void remove(hid_t file, const char* name) { h5::check(H5Ldelete(file, name, H5P_DEFAULT)); }
void remove_attribute(hid_t file, const char* name) { h5::check(H5Adelete(file, name)); }

template <class Value>
void replace_attribute(hid_t file, const char* name, Value value) {
  remove_attribute(file, name);
  h5::write_attribute(file, name, value);
}

// Flips a bit of the first word of a dataset of 32-bit words.
void flip(hid_t file, const char* name) {
  const h5::Handle dataset(H5Dopen2(file, name, H5P_DEFAULT));
  std::size_t count = 1;
  for (const hsize_t n : h5::extent_of(dataset)) count *= n;
  std::vector<u32> words(count);
  const h5::Handle type(H5Dget_type(dataset));
  h5::check(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, words.data()));
  words[0] ^= 1;
  h5::check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, words.data()));
}

// Another dataset of that name, of zeros.
void replace_words(hid_t file, const char* name, std::size_t rows, std::size_t columns) {
  remove(file, name);
  const std::vector<float> zeros(rows * columns);
  h5::write_words<float>(file, name, zeros.data(), rows, columns);
}

TEST(BadRecordings, ForeignAndChangedOnesAreRefused) {
  const std::string sizes = " has another shape than the scene gives it";
  const std::string table = " has another shape than the scene and the steps give it";
  const std::string scene_hash = "the compiled scene is damaged, its hash does not fit";
  const std::string version = RecordingReader(good_recording(), "x.h5").version();
  const std::string ours =
      ", wanted is " + std::to_string(recording_format) + ", of version " + version + "; record it again";
  const std::vector<Change> changes = {
      {"nothing", [](hid_t) {}, "accepted"},
      {"no format", [](hid_t f) { remove_attribute(f, "format"); }, "has no attribute format"},
      {"a later format", [](hid_t f) { replace_attribute(f, "format", recording_format + 1); },
       "it has format " + std::to_string(recording_format + 1) + ", of version " + version + ours},
      {"an earlier format of another version",
       [](hid_t f) {
         replace_attribute(f, "format", oldest_recording_format - 1);
         replace_attribute(f, "version", std::string("0.0.9"));
       },
       "it has format " + std::to_string(oldest_recording_format - 1) + ", of version 0.0.9" + ours},
      {"a format of another type", [](hid_t f) { replace_attribute(f, "format", 1.0); }, "format is of another type"},
      {"a format in words", [](hid_t f) { replace_attribute(f, "format", std::string("one")); },
       "format is of another type"},
      {"no version", [](hid_t f) { remove_attribute(f, "version"); }, "has no attribute version"},
      {"a version that is a number", [](hid_t f) { replace_attribute(f, "version", 0.1); },
       "version is of another type"},
      {"no precision", [](hid_t f) { remove_attribute(f, "precision"); }, "has no attribute precision"},
      {"half a precision", [](hid_t f) { replace_attribute(f, "precision", std::string("half")); },
       "precision is neither float nor double"},
      {"no scene", [](hid_t f) { remove_attribute(f, "scene"); }, "has no attribute scene"},
      {"no device", [](hid_t f) { remove_attribute(f, "device"); }, "has no attribute device"},
      {"no options", [](hid_t f) { remove_attribute(f, "options"); }, "has no attribute options"},
      {"no outcome", [](hid_t f) { remove_attribute(f, "outcome"); }, "has no attribute outcome"},
      {"no text", [](hid_t f) { remove(f, "scene_text"); }, "has no dataset scene_text"},
      {"a text of numbers", [](hid_t f) { replace_words(f, "scene_text", 2, 2); }, "scene_text is of another type"},
      {"no steps", [](hid_t f) { remove(f, "steps"); }, "has no dataset steps"},
      {"steps that are none", [](hid_t f) { replace_words(f, "steps", 5, 1); }, "steps is of another type"},
      {"no hashes", [](hid_t f) { remove(f, "state_hashes"); }, "has no dataset state_hashes"},
      {"no hashes of poses", [](hid_t f) { remove(f, "pose_hashes"); }, "has no dataset pose_hashes"},
      {"hashes that are none", [](hid_t f) { replace_words(f, "state_hashes", 5, 1); },
       "state_hashes is of another type"},
      {"hashes of no world", [](hid_t f) { replace_words(f, "state_hashes", 5, 0); },
       "state_hashes has no shape of hashes"},
      {"no scene inside", [](hid_t f) { remove(f, "compiled_scene"); }, "has no group compiled_scene"},
      {"no state", [](hid_t f) { remove(f, "initial_state"); }, "has no group initial_state"},
      {"no time step", [](hid_t f) { remove_attribute(h5::open_group(f, "compiled_scene"), "dt"); },
       "has no attribute dt"},
      {"a time step in double", [](hid_t f) { replace_attribute(h5::open_group(f, "compiled_scene"), "dt", 0.01); },
       "dt is of another type"},
      {"another time step", [](hid_t f) { replace_attribute(h5::open_group(f, "compiled_scene"), "dt", 0.5f); },
       scene_hash},
      {"another setting", [](hid_t f) { replace_attribute(h5::open_group(f, "compiled_scene"), "iterations", u32{3}); },
       scene_hash},
      {"no features", [](hid_t f) { remove_attribute(h5::open_group(f, "compiled_scene"), "features"); },
       "has no attribute features"},
      {"all features",
       [](hid_t f) { replace_attribute(h5::open_group(f, "compiled_scene"), "features", ~Features{0}); },
       "has no dataset pivots"},
      {"another mass", [](hid_t f) { flip(f, "compiled_scene/masses"); }, scene_hash},
      {"another body", [](hid_t f) { flip(f, "compiled_scene/body_infos"); }, scene_hash},
      {"no bodies", [](hid_t f) { remove(f, "compiled_scene/body_infos"); }, "has no bodies"},
      {"no worlds", [](hid_t f) { remove(f, "compiled_scene/world_ranges"); }, "has no bodies"},
      {"no shapes", [](hid_t f) { remove(f, "compiled_scene/shapes"); }, "has no dataset shapes"},
      {"masses of fewer", [](hid_t f) { replace_words(f, "compiled_scene/masses", 2, 8); }, "masses" + sizes},
      {"broad masses", [](hid_t f) { replace_words(f, "compiled_scene/masses", 65, 9); }, "masses" + sizes},
      {"no positions", [](hid_t f) { remove(f, "initial_state/positions"); }, "has no dataset positions"},
      {"positions of fewer", [](hid_t f) { replace_words(f, "initial_state/positions", 2, 4); }, "positions" + sizes},
      {"another start", [](hid_t f) { flip(f, "initial_state/positions"); },
       "the initial state is damaged, its hash does not fit"},
      {"another step", [](hid_t f) { flip(f, "initial_state/step_index"); },
       "the initial state is damaged, its hash does not fit"},
      {"more contacts than are there", [](hid_t f) { flip(f, "initial_state/cached_count"); }, "cached_keys" + sizes},
      {"no poses", [](hid_t f) { remove(f, "positions"); }, "has no dataset positions"},
      {"flat poses", [](hid_t f) { replace_words(f, "positions", 5, 3); }, "positions is no table of bodies"},
      {"no spins", [](hid_t f) { remove(f, "angular_velocities"); }, "has no dataset angular_velocities"},
      {"the wrong table",
       [](hid_t f) {
         remove(f, "positions");
         h5::check(H5Lmove(f, "orientations", f, "positions", H5P_DEFAULT, H5P_DEFAULT));
       },
       "positions" + table},
  };
  for (const Change& change : changes) {
    SCOPED_TRACE(change.what);
    const std::string expected = change.line == "accepted" ? change.line : unreadable + change.line;
    EXPECT_EQ(refusal_after(change.change), expected);
  }
}

TEST(BadRecordings, ThoseOfAnEarlierStepThanTheyBeginWithAreRefused) {
  const TemporaryFolder folder;
  const InitialState<float> state = compile<float>(read_scene("slide_to_roll"));
  Simulation<float> simulation = simulation_of(state);
  simulation.step();
  RecordingWriter<float> writer(folder.file("x.h5"), {}, state);
  record_step(writer, simulation);  // the second step, with the state before the first
  writer.close("finished");
  EXPECT_EQ(refusal(folder, folder.file("x.h5")), unreadable + "the first step does not follow the initial state");
}

}  // namespace
}  // namespace lockstep::bad_files_test
