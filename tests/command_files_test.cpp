// What a command writes takes the place of nothing else: of no other output, of nothing that it reads, of no recording
// that is being written; and what the disk does not take is told.
#include <sys/stat.h>
#include <unistd.h>

#include "host/error.hpp"
#include "host/record/hdf5.hpp"
#include "host/record/recording_reader.hpp"
#include "include/lockstep/world.hpp"
#include "tests/command_line.hpp"

namespace lockstep::command_files_test {
namespace {

class CommandFiles : public CommandLine {
 protected:
  std::string name(const std::string& of) const { return file(of).string(); }
  std::string short_run() const { return "run slide_to_roll --steps 3 --quiet --device reference "; }
};

TEST_F(CommandFiles, OutputsAreNoInputs) {
  const std::string scene = R"({"settings": {"steps": 2}, "bodies": [{"shape": "sphere", "radius": 1}]})";
  std::ofstream(file("scene.json")) << scene;
  fs::create_symlink("scene.json", file("link.json"));
  fs::create_hard_link(file("scene.json"), file("hard.json"));
  for (const std::string output : {"scene.json", "link.json", "hard.json", "./scene.json"})
    for (const std::string option : {"--report ", "--events "})
      expect_refused("run " + name("scene.json") + " --quiet --device reference " + option + name(output), 2,
                     "is the file of the scene, too");
  EXPECT_EQ(read_file(file("scene.json")), scene);

  ASSERT_EQ(run(short_run() + "--record " + name("r.h5")).status, 0);
  const std::string recording = read_file(file("r.h5"));
  expect_refused("render " + name("r.h5") + " --video " + name("r.h5"), 2, "is the file of the scene, too");
  expect_refused("verify " + name("r.h5") + " --picture " + name("r.h5"), 2, "is the file of the recording, too");
  EXPECT_EQ(read_file(file("r.h5")), recording);
}

TEST_F(CommandFiles, OutputsAreNotEachOther) {
  expect_refused(short_run() + "--report " + name("x") + " --events " + name("x"), 2, "is the file of --report, too");
  expect_refused(short_run() + "--record " + name("x") + " --checkpoint " + name("./x"), 2, "is the file of --record");
  expect_refused(short_run() + "--report ''", 2, "must be the name of a file, is empty");
  EXPECT_FALSE(fs::exists(file("x")));
  EXPECT_EQ(run(short_run() + "--report /dev/null --events /dev/null").status, 0);
  ASSERT_EQ(run(short_run() + "--checkpoint " + name("c")).status, 0);
  EXPECT_EQ(
      run("run slide_to_roll --steps 5 --quiet --device reference --resume " + name("c") + " --checkpoint " + name("c"))
          .status,
      0);
}

TEST_F(CommandFiles, AFilmIsNotWrittenOverSomethingElse) {
  std::ofstream(file("thesis.txt")) << "years of work";
  expect_refused("render slide_to_roll --quiet --device reference --video " + name("thesis.txt"), 2,
                 "is there already and is something else");
}

// A link that waits under the name of an unfinished file.
TEST_F(CommandFiles, ALinkBesideARecordingIsNotFollowed) {
  std::ofstream(file("thesis.txt")) << "years of work";
  fs::create_symlink("thesis.txt", file("r.h5.part"));
  EXPECT_EQ(run(short_run() + "--record " + name("r.h5")).status, 0);
  EXPECT_EQ(read_file(file("thesis.txt")), "years of work");
}

TEST_F(CommandFiles, KeepTheModeOfWhatTheyReplace) {
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(run(short_run() + "--record " + name("r.h5") + " --report " + name("r.json")).status, 0);
    if (i == 1) break;
    ASSERT_EQ(::chmod(name("r.h5").c_str(), 0640), 0);
    ASSERT_EQ(::chmod(name("r.json").c_str(), 0600), 0);
  }
  EXPECT_EQ(static_cast<unsigned>(fs::status(file("r.h5")).permissions()), 0640u);
  EXPECT_EQ(static_cast<unsigned>(fs::status(file("r.json")).permissions()), 0600u);
}

Scene ball() {
  Scene scene;
  scene.name = scene.source = "ball";
  BodyDescription body;
  body.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.5});
  make_solid(body, 1);
  scene.bodies.push_back(body);
  return scene;
}

TEST_F(CommandFiles, OneWriterOfARecording) {
  World first(ball(), {.device = "reference"}), second(ball(), {.device = "reference"});
  first.record(name("r.h5"));
  first.step();
  second.record(name("r.h5"));
  try {
    second.step();
    FAIL() << "two write one recording";
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::input);
    EXPECT_NE(std::string(error.what()).find("is a recording that is being written"), std::string::npos);
  }
  expect_refused(short_run() + "--record " + name("r.h5"), 2, "is a recording that is being written");
  first.step();
  first.end_recording();
  EXPECT_EQ(RecordingReader(name("r.h5")).steps(), 2u);
  EXPECT_EQ(run(short_run() + "--record " + name("r.h5")).status, 0);  // nobody writes it any more
}

TEST_F(CommandFiles, ARecordingThatWasRemovedIsTold) {
  World world(ball(), {.device = "reference"});
  world.record(name("r.h5"));
  world.step();
  fs::remove(file("r.h5"));
  EXPECT_THROW(world.end_recording(), Error);
}

TEST_F(CommandFiles, FullDisksAreTold) {
  const Outcome events = run("run dominoes --quiet --device reference --steps 100 --events /dev/full");
  EXPECT_EQ(events.status, 3);
  EXPECT_NE(events.err.find("the events cannot be written to their end: No space left"), std::string::npos);
  for (const std::string command : {"run slide_to_roll --steps 2 --device reference", "devices", "scenes"}) {
    SCOPED_TRACE(command);
    const Outcome outcome = run_command(std::string(LOCKSTEP_PROGRAM) + " " + command + " >/dev/full");
    EXPECT_EQ(outcome.status, 3);
    EXPECT_NE(outcome.err.find("No space left"), std::string::npos) << outcome.err;
  }
  const Outcome limited = run_command("ulimit -f 1; " LOCKSTEP_PROGRAM " " + short_run() + "--record " + name("r.h5"));
  EXPECT_EQ(limited.status, 3) << limited.err;
  EXPECT_EQ(std::count(limited.err.begin(), limited.err.end(), '\n'), 1) << limited.err;
}

// Numbers that a recording does not hold itself: an external link, external storage, a virtual dataset.
TEST_F(CommandFiles, OtherFilesAreNotRead) {
  ASSERT_EQ(run(short_run() + "--record " + name("r.h5")).status, 0);
  const auto refused = [&](const char* how, const std::function<void(hid_t)>& change) {
    SCOPED_TRACE(how);
    fs::copy_file(file("r.h5"), file("changed.h5"), fs::copy_options::overwrite_existing);
    {
      const h5::Handle changed(H5Fopen(name("changed.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
      h5::check(H5Ldelete(changed, "positions", H5P_DEFAULT));
      change(changed);
    }
    expect_refused("verify --device reference " + name("changed.h5"), 2, "positions");
    expect_refused("export " + name("changed.h5") + " -o " + name("x.glb"), 2, "positions");
  };
  const hsize_t extent[] = {3, 2, 3};
  const h5::Handle space = h5::space(extent);
  refused("link", [&](hid_t changed) {
    h5::check(H5Lcreate_external(name("r.h5").c_str(), "positions", changed, "positions", H5P_DEFAULT, H5P_DEFAULT));
  });
  refused("storage", [&](hid_t changed) {
    const h5::Handle properties(H5Pcreate(H5P_DATASET_CREATE));
    h5::check(H5Pset_external(properties, "/etc/passwd", 0, 72));
    h5::Handle(H5Dcreate2(changed, "positions", H5T_IEEE_F32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT));
  });
  refused("virtual", [&](hid_t changed) {
    const h5::Handle properties(H5Pcreate(H5P_DATASET_CREATE));
    h5::check(H5Pset_virtual(properties, space, name("r.h5").c_str(), "positions", space));
    h5::Handle(H5Dcreate2(changed, "positions", H5T_IEEE_F32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT));
  });
  const hsize_t huge[] = {3, 2, 300000000};
  refused("nothing there", [&](hid_t changed) {
    h5::Handle(
        H5Dcreate2(changed, "positions", H5T_IEEE_F32LE, h5::space(huge), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  });
}

// A folder whose name a plotter would run.
TEST_F(CommandFiles, FolderNamesAreNotRun) {
  const std::string folder = name("`touch ran`'\"$(touch ran)");
  const std::string quoted = "'" + name("`touch ran`") + "'\\''\"$(touch ran)'";
  const Outcome outcome = run_command(
      "cd " + name("") +
      " && " LOCKSTEP_PROGRAM " bench slide_to_roll --device reference --precision float --settings 1 --out " + quoted);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(fs::path(folder) / "bench.csv"));
  EXPECT_FALSE(fs::exists(file("ran")));
}

TEST_F(CommandFiles, NoNumberIsNone) {
  expect_refused("render slide_to_roll --fps nan", 2, "must be a finite number");
  expect_refused("run slide_to_roll --seed 010", 2, "must not begin with 0");
  expect_refused("run slide_to_roll --worlds 010", 2, "must not begin with 0");
  expect_refused("render slide_to_roll --scale nan --color-by speed", 2, "must be a number > 0");
  expect_refused("run slide_to_roll --device 99", 2, "there is no device 99");
}

}  // namespace
}  // namespace lockstep::command_files_test
