// The program as a user meets it: what it prints, where, and with which exit status.
#include <map>

#include "host/scene/setting_table.hpp"
#include "tests/command_line.hpp"

namespace lockstep::cli_test {
namespace {

TEST_F(CommandLine, HelpsWithAnExampleForEachCommand) {
  for (const char* command : {"devices", "scenes", "run", "check", "verify", "render", "solve", "export", "bench"}) {
    const Outcome outcome = run(std::string(command) + " --help");
    EXPECT_EQ(outcome.status, 0);
    EXPECT_NE(outcome.out.find("Example"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find(std::string(":\n  lockstep ") + command), std::string::npos) << outcome.out;
  }
  EXPECT_EQ(run("--help").status, 0);
}

TEST_F(CommandLine, RefusesBadUsageInOneLine) {
  expect_refused("", 2, "--help");
  expect_refused("frobnicate", 2, "no command 'frobnicate'");
  expect_refused("run", 2, "scene");
  expect_refused("run slide_to_roll --bogus", 2, "--bogus");
  expect_refused("run slide_to_roll --iterationz 5", 2, "no option \"--iterationz\"; did you mean \"--iterations\"?");
  expect_refused("run slide_to_roll --steps -3", 2, "--steps");
  expect_refused("run slide_to_roll --steps many", 2, "--steps");
  expect_refused("run slide_to_roll --steps 10 --time 1", 2, "--time");
  expect_refused("run slide_to_roll --dt 0", 2, "--dt: must be > 0, is 0");
  expect_refused("run slide_to_roll --dt nan", 2, "--dt: must be a number, is \"nan\"");
  expect_refused("run slide_to_roll --tolerance -1", 2, "--tolerance: must be >= 0, is -1");
  expect_refused("run slide_to_roll --solver magic", 2, "gauss_seidel");
  expect_refused("run slide_to_roll --precision half", 2, "float");
  expect_refused("run slide_to_roll --lanes 3", 2, "--lanes");
  expect_refused("run slide_to_roll --device toaster", 2, "toaster");
  expect_refused("run slide_to_roll --device reference --lanes 8", 2, "reference");
}

TEST_F(CommandLine, NamesADeviceThatIsNotThere) { expect_refused("run slide_to_roll --device 99", 2, "99"); }

TEST_F(CommandLine, NamesTheChoicesThereAre) {
  expect_refused("run slabs --solver magic", 2,
                 "--solver: unknown solver \"magic\"; known: gauss_seidel, small_steps, jacobi, gradient, "
                 "accelerated_gradient, dense_gauss_seidel, cell_gauss_seidel, auto, nsgs");
  expect_refused("run slabs --solver small_step", 2, "did you mean \"small_steps\"?");
  expect_refused("run slabs --friction-model 1", 2,
                 "--friction-model: unknown friction model \"1\"; known: cones, patches");
}

// Each setting has an option of its name, which changes it.
TEST_F(CommandLine, TakesEachSettingAsAnOption) {
  const std::string help = run("run --help").out;
  for (const SettingInfo& row : setting_infos()) {
    std::string option = "--" + std::string(row.name);
    std::ranges::replace(option, '_', '-');
    EXPECT_NE(help.find(option), std::string::npos) << option;
    const bool is_own = option == "--events" || option == "--sleeping" || option == "--solver";
    if (!is_own) expect_refused("run slabs " + option + " qqqqqqqq", 2, option + ": ");
  }
  const nlohmann::json slow = report_of("free_flight --steps 4 --device reference --speed-limit 1e6 --margin 0.01");
  EXPECT_EQ(slow["steps"], 4);
  expect_refused("run slide_to_roll --device reference --speed-limit 0.001", 1, "speed");
}

TEST_F(CommandLine, NamesWhatIsWrongWithAScene) {
  expect_refused("run no_such_scene", 2, "no_such_scene");
  std::ofstream(file("bad.json")) << R"({"bodies": [{"shapes": [{"type": "sphere", "radius": 1}], "mass": -1}]})";
  expect_refused("run " + file("bad.json").string(), 2, "bad.json: /bodies/0/mass");
}

TEST_F(CommandLine, RefusesAReportThatCannotBeWritten) {
  expect_refused("run slide_to_roll --report /nowhere/report.json", 2, "/nowhere/report.json");
  expect_refused("run slide_to_roll --report " + file("").string(), 2, "cannot be written");
}

TEST_F(CommandLine, LeavesNoReportBehindWhereARunFails) {
  expect_refused("run no_such_scene --report " + file("report.json").string(), 2, "no_such_scene");
  EXPECT_FALSE(fs::exists(file("report.json")));
  std::ofstream(file("report.json")) << "what was there";
  expect_refused("run no_such_scene --report " + file("report.json").string(), 2, "no_such_scene");
  EXPECT_EQ(read_file(file("report.json")), "what was there");
}

TEST_F(CommandLine, ListsScenesAndDevices) {
  EXPECT_NE(run("scenes").out.find("slide_to_roll"), std::string::npos);
  const Outcome devices = run("devices");
  EXPECT_EQ(devices.status, 0);
  EXPECT_NE(devices.out.find("auto is "), std::string::npos) << devices.out;
  EXPECT_NE(devices.out.find("bit-exact"), std::string::npos) << devices.out;
  EXPECT_NE(devices.out.find("OpenGL ES 3"), std::string::npos) << devices.out;
}

TEST_F(CommandLine, EndsARunWithATable) {
  const Outcome outcome = run("run slide_to_roll --device reference --steps 20");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.err, "") << "no progress bar where stderr is no terminal";
  for (const char* word : {"ms a step", "penetration", "residual", "state hash"})
    EXPECT_NE(outcome.out.find(word), std::string::npos) << outcome.out;
}

TEST_F(CommandLine, DevicesAndReferenceReportTheSameHashes) {
  const nlohmann::json reference = report_of("spheres_small --steps 40 --device reference");
  for (const char* options : {"--device cpu", "--device auto --lanes 8 --work-group 3", "--device auto --lanes 16"}) {
    const nlohmann::json device = report_of(std::string("spheres_small --steps 40 ") + options);
    EXPECT_EQ(device["state_hash"], reference["state_hash"]) << options;
    EXPECT_EQ(device["pose_hash"], reference["pose_hash"]) << options;
    EXPECT_NE(device["device"], reference["device"]);
  }
}

TEST_F(CommandLine, OptionsArePassedToTheSimulation) {
  const nlohmann::json plain = report_of("spheres_small --device reference --time 0.5 --dt 0.01");
  EXPECT_EQ(plain["steps"], 50);
  EXPECT_DOUBLE_EQ(plain["dt"].get<double>(), 0.01);
  EXPECT_EQ(plain["precision"], "float");
  for (const char* option : {"--substeps 2", "--iterations 3", "--precision double"}) {
    const nlohmann::json other =
        report_of(std::string("spheres_small --device reference --time 0.5 --dt 0.01 ") + option);
    EXPECT_NE(other["state_hash"], plain["state_hash"]) << option;
  }
  EXPECT_TRUE(plain["sweeps_max"].is_null());
  const nlohmann::json short_sweeps =
      report_of("spheres_small --device reference --time 0.5 --dt 0.01 --tolerance 0.5");
  EXPECT_EQ(short_sweeps["tolerance"], 0.5);
  EXPECT_LT(short_sweeps["sweeps_median"], 10);
  EXPECT_LE(short_sweeps["sweeps_max"], 10);
  EXPECT_EQ(plain["stage_ms"].size(), 0u);
  EXPECT_GT(report_of("spheres_small --device reference --steps 20 --profile")["stage_ms"]["solve_constraints"], 0);
}

TEST_F(CommandLine, LetsWhatRestsSleep) {
  const nlohmann::json asleep = report_of("box_stack --steps 120 --sleeping 0.5 --device reference");
  EXPECT_EQ(asleep["asleep"], 10);
  EXPECT_EQ(asleep["islands_asleep"], 1);
  EXPECT_EQ(asleep["wakings"], 0);
  EXPECT_TRUE(report_of("sleeping_piles --steps 2 --sleeping off --device reference")["asleep"].is_null());
  expect_refused("run box_stack --sleeping soon", 2, "--sleeping: must be a number > 0, is 'soon'");
  expect_refused("run sleeping_piles --solver auto", 2, "/settings/sleeping: auto is an oracle");
  expect_refused("run sleeping_piles --tolerance 0.001", 2, "/settings/sleeping: does not go with a tolerance");
  expect_refused("run particles_pile --sleeping 1", 2, "/settings/sleeping: does not go with particles");
}

TEST_F(CommandLine, GoesOnFromACheckpoint) {
  const std::string checkpoint = file("a.h5").string();
  const nlohmann::json whole = report_of("spheres_small --device reference --steps 40");
  EXPECT_EQ(run("run spheres_small --device reference --steps 15 --quiet --checkpoint " + checkpoint).status, 0);
  const nlohmann::json rest = report_of("spheres_small --device reference --steps 40 --resume " + checkpoint);
  EXPECT_EQ(rest["state_hash"], whole["state_hash"]);
  EXPECT_EQ(rest["first_step"], 15);
  EXPECT_EQ(rest["steps"], 25);
  EXPECT_EQ(run("check spheres_small --steps 20 --quiet --resume " + checkpoint).status, 0);
  expect_refused("run spheres_small --steps 15 --resume " + checkpoint, 2, "is 15 steps old already");
  expect_refused("run rover --resume " + checkpoint, 2, "is a checkpoint of scene");
  expect_refused("run rover --resume " + file("none.h5").string(), 2, "no such file");
  expect_refused("run rover --checkpoint /nowhere/a.h5", 2, "the checkpoint cannot be written");
}

TEST_F(CommandLine, VerifiesARecording) {
  const std::string record = file("x.h5").string();
  EXPECT_EQ(run("run spheres_small --steps 20 --quiet --device reference --record " + record).status, 0);
  const Outcome outcome = run("verify " + record);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("20 steps, every state hash equal"), std::string::npos) << outcome.out;
  EXPECT_EQ(run("verify --quiet " + record + " --device reference").out, "");
  expect_refused("verify " + file("none.h5").string(), 2, "none.h5: no such file");
  expect_refused("run slide_to_roll --record /nowhere/x.h5", 2, "the recording cannot be written");
  std::ofstream(file("mine.json")) << "{}";
  expect_refused("run slide_to_roll --record " + file("mine.json").string(), 2, "does not overwrite it");
}

TEST_F(CommandLine, ChecksADeviceAgainstTheReference) {
  for (const char* precision : {"float", "double"}) {
    const Outcome outcome = run(std::string("check spheres_small --steps 20 --precision ") + precision);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("words compared: equal"), std::string::npos) << outcome.out;
  }
  expect_refused("check spheres_small --device reference", 2, "reference");
}

TEST_F(CommandLine, ChecksSeveralScenesAndNamesEachThatDiffers) {
  const Outcome equal = run("check slide_to_roll spheres_small --steps 2");
  EXPECT_EQ(equal.status, 0) << equal.err;
  EXPECT_NE(equal.out.find("slide_to_roll, "), std::string::npos) << equal.out;
  EXPECT_NE(equal.out.find("spheres_small, "), std::string::npos) << equal.out;
  // sums in another order, as fast mathematics allows
  const Outcome outcome = run_command("export LOCKSTEP_CL_OPTIONS=-cl-fast-relaxed-math; " LOCKSTEP_PROGRAM
                                      " check free_flight free_flight --steps 3");
  EXPECT_EQ(outcome.status, 1);
  const std::string line = "free_flight, float: DIFFERENT: step 0, integrate_velocities: motions[";
  const std::size_t first = outcome.out.find(line);
  ASSERT_NE(first, std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find(line, first + 1), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.err, "lockstep: check: 2 of 2 scenes differ\n");
  expect_refused("check slide_to_roll nowhere", 2, "nowhere: no such file");
  expect_refused("check slide_to_roll spheres_small --picture " + file("a.png").string(), 2, "--picture");
}

TEST_F(CommandLine, EventsAreWrittenALineEach) {
  const fs::path events = file("events.jsonl");
  const nlohmann::json report = report_of("sensor_gate --device reference --events " + events.string());
  std::ifstream lines(events);
  std::map<std::string, int> counts;
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json event = nlohmann::json::parse(line);
    ++counts[event["event"]];
    EXPECT_EQ(event["event"] == "contact_begin" ? event["name_b"] : event["name_a"],
              event["event"] == "contact_begin" ? "ground" : "gate");
  }
  EXPECT_EQ(counts["contact_begin"], 8);
  EXPECT_EQ(counts["trigger_enter"], 8);
  EXPECT_EQ(counts["trigger_leave"], 8);
  EXPECT_EQ(report["trigger_leaves"], 8);
  EXPECT_EQ(report["contact_ends"], 0);
  expect_refused("run sensor_gate --events /no/such/folder/events.jsonl", 2, "/no/such/folder/events.jsonl: ");
}

}  // namespace
}  // namespace lockstep::cli_test
