// Requests to end: what there is, is kept, and the exit status says which signal it was.
#include <fcntl.h>
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "host/error.hpp"
#include "host/record/recording_reader.hpp"
#include "tests/child_program.hpp"
#include "tests/command_line.hpp"

namespace lockstep::interrupt_test {
namespace {

void wait_a_moment() { std::this_thread::sleep_for(std::chrono::milliseconds(2)); }

u32 steps_recorded(const fs::path& record) {
  try {
    return RecordingReader(record.string()).steps();
  } catch (const Error&) {
    return 0;  // not there yet
  }
}

std::string in_words(int status) {
  return WIFEXITED(status) ? "status " + std::to_string(WEXITSTATUS(status))
                           : "signal " + std::to_string(WTERMSIG(status));
}

class Interrupted : public CommandLine {
 protected:
  const fs::path record = file("x.h5"), report = file("x.json"), checkpoint = file("c.h5");

  std::vector<std::string> kept(std::vector<std::string> arguments) const {
    for (const std::string& word :
         {std::string("--quiet"), std::string("--device"), std::string("reference"), std::string("--record"),
          record.string(), std::string("--report"), report.string(), std::string("--checkpoint"), checkpoint.string()})
      arguments.push_back(word);
    return arguments;
  }

  // Report, recording and checkpoint are those of one run, which replays and goes on.
  void expect_all_is_kept(const std::string& scene_and_options) const {
    const auto json = nlohmann::json::parse(read_file(report));
    const u32 steps = json["steps"];
    EXPECT_EQ(json["interrupted"], true);
    const RecordingReader recording(record.string());
    EXPECT_EQ(recording.outcome(), "interrupted");
    EXPECT_EQ(recording.steps(), steps);
    const Outcome verified = run("verify " + record.string() + " --device reference");
    EXPECT_EQ(verified.status, 0) << verified.err;
    const Outcome resumed =
        run("run " + scene_and_options + " --device reference --quiet --steps " + std::to_string(steps + 1) +
            " --resume " + checkpoint.string() + " --report " + file("resumed.json").string());
    EXPECT_EQ(resumed.status, 0) << resumed.err;
    const auto rest = nlohmann::json::parse(read_file(file("resumed.json")));
    EXPECT_EQ(rest["first_step"], steps);
    EXPECT_EQ(rest["steps"], 1);
  }
};

TEST_F(Interrupted, ARunKeepsReportRecordingAndCheckpointAndTellsTheSignal) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    SCOPED_TRACE(signal);
    for (const fs::path& path : {record, report, checkpoint}) fs::remove(path);
    ChildProgram program(kept({"run", "spheres_small", "--steps", "1000000"}));
    while (program.runs() && steps_recorded(record) == 0) wait_a_moment();
    EXPECT_FALSE(fs::exists(report)) << "it is there whole or not at all";
    EXPECT_EQ(in_words(program.end(signal)), in_words((128 + signal) << 8));
    expect_all_is_kept("spheres_small");
  }
}

// The step that an oracle is in the midst of is given up.
TEST_F(Interrupted, AStepOfAnOracleIsGivenUp) {
  ChildProgram program(kept({"run", "rag_doll", "--solver", "nsgs", "--tolerance", "1e-4", "--steps", "1000000"}));
  while (program.runs() && (!fs::exists(record) || program.cpu_seconds() < 1)) wait_a_moment();
  EXPECT_EQ(in_words(program.end(SIGINT)), "status 130");
  expect_all_is_kept("rag_doll --solver nsgs --tolerance 1e-4");
}

// A scene that comes through a pipe is waited for.
TEST_F(Interrupted, BeforeThereIsAnythingToKeepTheProgramEndsAtOnceAndLeavesNothing) {
  const fs::path scene = file("scene.json");
  ASSERT_EQ(mkfifo(scene.c_str(), 0600), 0);
  ChildProgram program(kept({"run", scene.string()}));
  const int writer = open(scene.c_str(), O_WRONLY);  // until it reads
  EXPECT_EQ(in_words(program.end(SIGTERM)), "status 143");
  close(writer);
  for (const fs::path& path : {record, report, checkpoint}) EXPECT_FALSE(fs::exists(path)) << path;
}

// Its first step takes minutes, and nothing looks meanwhile.
TEST_F(Interrupted, ASecondRequestEndsTheProgramAtOnceAndFilesAreWhole) {
  std::ofstream(report) << "the report of another run\n";
  ChildProgram program(kept({"run", "pyramid20", "--steps", "10", "--iterations", "100000"}));
  while (program.runs() && !fs::exists(record)) wait_a_moment();
  const double prepared = program.cpu_seconds();  // it defers requests a moment later
  while (program.runs() && program.cpu_seconds() < prepared + 0.5) wait_a_moment();
  program.send(SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // or the two are one request
  ASSERT_TRUE(program.runs());
  EXPECT_EQ(in_words(program.end(SIGINT)), "status 130");
  EXPECT_EQ(read_file(report), "the report of another run\n");
  EXPECT_FALSE(fs::exists(checkpoint));
  const RecordingReader recording(record.string());
  EXPECT_EQ(recording.outcome(), "running");
  EXPECT_EQ(recording.steps(), 0u);
}

// nohup(1) has a program go on when its terminal goes.
TEST_F(Interrupted, AHangupThatIsIgnoredStaysSo) {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  ChildProgram program(kept({"run", "spheres_small", "--steps", "200"}));
  std::signal(SIGHUP, before);
  while (program.runs() && !fs::exists(record)) wait_a_moment();
  EXPECT_EQ(in_words(program.end(SIGHUP)), "status 0");
}

TEST_F(Interrupted, ASolveEndsBetweenIterationsAndReportsTheBestThatItHas) {
  const std::string problem = file("p.hdf5").string();
  ASSERT_EQ(run("export pyramid20 --at 20 --device reference --quiet -o " + problem).status, 0);
  ChildProgram program({"solve", problem, "--solver", "projected_gradient", "--tolerance", "1e-300", "--iterations",
                        "4000000000", "--seconds", "1e9", "--quiet", "--report", report.string()});
  while (program.runs() && program.cpu_seconds() < 1) wait_a_moment();
  EXPECT_EQ(in_words(program.end(SIGINT)), "status 130");
  const auto json = nlohmann::json::parse(read_file(report));
  EXPECT_EQ(json["stop"], "interrupted");
  EXPECT_EQ(json["converged"], false);
  EXPECT_GT(json["iterations"], 0);
  EXPECT_LT(json["residual"], 1);
}

TEST_F(Interrupted, ABenchmarkKeepsTheTrialsThatWereDone) {
  ChildProgram program({"bench", "slide_to_roll", "pyramid20", "--device", "reference", "--out", file("out").string()});
  const auto lines = [&] {
    const std::string text = read_file(file("out") / "bench.csv");
    return std::count(text.begin(), text.end(), '\n');
  };
  while (program.runs() && lines() < 7) wait_a_moment();
  EXPECT_EQ(in_words(program.end(SIGTERM)), "status 143");
  const auto json = nlohmann::json::parse(read_file(file("out") / "bench.json"));
  std::size_t errors = 0;
  for (const auto& benched : json)
    for (const auto& trial : benched["trials"]) errors += trial["errors"].size();
  EXPECT_EQ(errors + 1, static_cast<std::size_t>(lines())) << "those of the table, below its head";
}

// As of `lockstep scenes | head -1`, where nobody reads what comes after.
TEST_F(Interrupted, WhoReadsNoFurtherEndsTheProgramWithoutAWord) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  close(ends[0]);
  const int out = dup(STDOUT_FILENO), err = dup(STDERR_FILENO);
  const int words = open(file("err").c_str(), O_CREAT | O_WRONLY, 0600);
  std::fflush(nullptr);
  dup2(ends[1], STDOUT_FILENO);
  dup2(words, STDERR_FILENO);
  ChildProgram program({"run", "slide_to_roll", "--steps", "5", "--device", "reference", "--report", report.string()});
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  for (const int descriptor : {ends[1], out, err, words}) close(descriptor);
  EXPECT_EQ(in_words(program.wait()), "signal 13");
  EXPECT_EQ(read_file(file("err")), "");
  EXPECT_EQ(nlohmann::json::parse(read_file(report))["steps"], 5);
}

}  // namespace
}  // namespace lockstep::interrupt_test
