// What fails while the program runs: it says so in one line, and what it wrote is whole.
#include <signal.h>

#include <chrono>
#include <future>
#include <thread>

#include "host/record/recording_reader.hpp"
#include "tests/command_line.hpp"

namespace lockstep::failures_test {
namespace {

class Failures : public CommandLine {
 protected:
  std::string program(const std::string& arguments) const { return LOCKSTEP_PROGRAM " " + arguments; }

  // The shell's limit on a process: "-v 300000" (kB of memory), "-f 2000" (blocks of a file).
  std::string limited(const std::string& limit, const std::string& arguments) const {
    return "trap '' XFSZ; ulimit " + limit + "; exec " + program(arguments);
  }

  // With a device that is lost at this call of this OpenCL function.
  Outcome run_until_lost(const std::string& function, u32 call, const std::string& arguments) const {
    return run_command("LD_PRELOAD=" LOCKSTEP_LOST_DEVICE " LOCKSTEP_LOST_IN=" + function +
                       " LOCKSTEP_LOST_AT=" + std::to_string(call) + " " + program(arguments));
  }

  // The recording of a run that failed with `outcome`: it says why it ends, and its steps are those of the true run.
  u32 expect_true_steps(const fs::path& path, const Outcome& outcome) const {
    EXPECT_EQ(outcome.status, 3);
    const RecordingReader recording(path);
    EXPECT_EQ("lockstep: " + recording.outcome() + "\n", outcome.err);
    if (recording.steps() == 0) return 0;
    const Outcome verified = run("verify --device reference " + path.string());
    EXPECT_EQ(verified.status, 0) << verified.err;
    EXPECT_NE(verified.out.find("every state hash equal"), std::string::npos) << verified.out;
    return recording.steps();
  }
};

TEST_F(Failures, AFullDiskEndsTheRunWithAWholeRecording) {
  const std::string record = file("x.h5").string();
  const Outcome outcome =
      run_command(limited("-f 2000", "run spheres_small --steps 20000 --quiet --device reference --record " + record));
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.err, "lockstep: " + record +
                             ": the recording cannot be written: File too large; the steps that are there can be "
                             "read\n");
  const Outcome verified = run("verify --device reference " + record);
  EXPECT_EQ(verified.status, 0) << verified.err;
  EXPECT_NE(verified.out.find("every state hash equal"), std::string::npos) << verified.out;
}

TEST_F(Failures, AFullDiskLeavesTheOldRecordingAndTheOldCheckpoint) {
  const std::string record = file("x.h5").string(), checkpoint = file("c.h5").string();
  const std::string few = "run spheres_small --steps 3 --quiet --device reference";
  EXPECT_EQ(run(few + " --record " + record + " --checkpoint " + checkpoint).status, 0);
  const std::string old_record = read_file(record), old_checkpoint = read_file(checkpoint);
  EXPECT_EQ(run_command(limited("-f 10", few + " --record " + record)).status, 3);
  EXPECT_EQ(run_command(limited("-f 10", few + " --checkpoint " + checkpoint)).status, 3);
  EXPECT_EQ(read_file(record), old_record);
  EXPECT_EQ(read_file(checkpoint), old_checkpoint);
}

TEST_F(Failures, ABodyGoneBadClosesTheRecordingBeforeIt) {
  std::ofstream(file("fast.json")) << R"({"settings": {"speed_limit": 1, "dt": 0.01},
    "bodies": [{"mass": 1, "shapes": [{"type": "sphere", "radius": 0.1}]}]})";
  const std::string record = file("x.h5").string();
  const Outcome outcome = run("run " + file("fast.json").string() + " --device reference --quiet --record " + record);
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.err.rfind("lockstep: step 10, integrate_velocities: body 0 of world 0: ", 0), 0u) << outcome.err;
  const RecordingReader recording(record);
  EXPECT_EQ(recording.steps(), 10u);
  EXPECT_EQ("lockstep: " + recording.outcome() + "\n", outcome.err);
}

bool has_steps(const std::string& record) {
  try {
    return RecordingReader(record).steps() > 0;
  } catch (const Error&) {
    return false;  // not there yet
  }
}

// Asked twice in a moment, as timeout(1) asks a program and its group.
TEST_F(Failures, AskedToEndItWritesEverything) {
  const std::string record = file("x.h5").string(), checkpoint = file("c.h5").string(), id = file("id").string();
  const std::string command = program("run spheres_small --steps 1000000 --device reference --record " + record +
                                      " --checkpoint " + checkpoint);
  auto running =
      std::async(std::launch::async, [&] { return run_command("sh -c 'echo $$ > " + id + "; exec " + command + "'"); });
  while (running.wait_for(std::chrono::milliseconds(10)) != std::future_status::ready && !has_steps(record)) {
  }
  const pid_t program_id = std::stoi(read_file(id));
  kill(program_id, SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(1));  // or the two are one
  kill(program_id, SIGTERM);
  const Outcome outcome = running.get();
  EXPECT_EQ(outcome.status, 128 + SIGTERM) << outcome.err;
  EXPECT_NE(outcome.out.find("interrupted: "), std::string::npos) << outcome.out;
  const RecordingReader recording(record);
  EXPECT_EQ(recording.outcome(), "interrupted");
  const std::string resumed = "run spheres_small --device reference --quiet --steps " +
                              std::to_string(recording.steps() + 1) + " --resume " + checkpoint;
  EXPECT_EQ(run(resumed).status, 0);
}

TEST_F(Failures, WithoutOpenClTheReferenceIsUsed) {
  const std::string none = "OCL_ICD_VENDORS=/nonexistent/ ";
  const Outcome outcome = run_command(none + program("run slide_to_roll --steps 5"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "lockstep: there is no OpenCL device here; the plain C++ reference takes its place\n");
  EXPECT_EQ(outcome.out.rfind("slide_to_roll on reference, ", 0), 0u) << outcome.out;
  EXPECT_EQ(run_command(none + program("run slide_to_roll --steps 5 --device cpu")).status, 2);
}

// A home where nothing can be written: no binaries are kept, and nothing else is missed.
TEST_F(Failures, AHomeThatCannotBeWrittenIsNoHindrance) {
  const std::string home = "POCL_CACHE_DIR=\"${POCL_CACHE_DIR:-$HOME/.cache/pocl}\" HOME=/dev/null ";
  const Outcome outcome = run_command("unset LOCKSTEP_CACHE XDG_CACHE_HOME; " + home +
                                      program("run slide_to_roll --device auto --steps 5"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
}

TEST_F(Failures, ALostDeviceLeavesItsRecordingWholeOnTheDevice) {
  const std::pair<std::string, u32> losses[] = {
      {"clEnqueueNDRangeKernel", 1000}, {"clEnqueueReadBuffer", 100}, {"clFinish", 6}};
  for (const auto& [function, call] : losses) {
    SCOPED_TRACE(function);
    const fs::path record = file(function + ".h5");
    const Outcome outcome = run_until_lost(
        function, call, "run spheres_small --steps 300 --quiet --device cpu --record " + record.string());
    EXPECT_NE(outcome.err.find(function + " failed: CL_"), std::string::npos) << outcome.err;
    const u32 steps = expect_true_steps(record, outcome);
    EXPECT_GT(steps, 0u);
    EXPECT_LT(steps, 300u);
  }
}

// Two layers of bars fly at each other until each bar of one meets each of the other: lists outgrow their first room
// in flight. Every buffer that is made fails in turn, from the device's first on.
TEST_F(Failures, ADeviceWithoutRoomForMoreLeavesItsRecordingWholeOnTheDevice) {
  std::ofstream(file("bars.json")) << R"({"gravity": [0, 0, 0], "settings": {"dt": 0.01}, "bodies": [
    {"generator": "line", "count": 30, "step": [0.2, 0, 0], "bodies": [
      {"mass": 1, "position": [-3, 0, 0], "shapes": [{"type": "box", "size": [0.1, 8, 0.1]}]}]},
    {"generator": "line", "count": 30, "step": [0, 0.2, 0], "bodies": [
      {"mass": 1, "position": [0, -3, 0.2], "velocity": [0, 0, -1],
       "shapes": [{"type": "box", "size": [8, 0.1, 0.1]}]}]}]})";
  const fs::path record = file("bars.h5");
  const std::string command =
      "run " + file("bars.json").string() + " --steps 20 --quiet --device cpu --record " + record.string();
  u32 in_flight = 0;
  for (u32 call = 1;; call += 6) {
    SCOPED_TRACE(call);
    fs::remove(record);
    const Outcome outcome = run_until_lost("clCreateBuffer", call, command);
    if (outcome.status == 0) break;
    EXPECT_EQ(outcome.status, 3);
    EXPECT_NE(outcome.err.find("clCreateBuffer failed: CL_MEM_OBJECT_ALLOCATION_FAILURE"), std::string::npos)
        << outcome.err;
    if (fs::exists(record)) in_flight += expect_true_steps(record, outcome) > 0;
  }
  EXPECT_GT(in_flight, 0u);
}

TEST_F(Failures, TooLittleMemoryIsSaid) {
  std::ofstream(file("large.json")) << R"({"bodies": [{"generator": "line", "count": 1000000, "step": [2, 0, 0],
    "bodies": [{"mass": 1, "shapes": [{"type": "sphere", "radius": 0.1}]}]}]})";
  const Outcome outcome =
      run_command(limited("-v 500000", "run " + file("large.json").string() + " --device reference --steps 1"));
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.err, "lockstep: out of memory; this machine needs a smaller scene\n");
}

}  // namespace
}  // namespace lockstep::failures_test
