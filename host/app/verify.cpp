#include <fmt/format.h>

#include "host/app/commands.hpp"
#include "host/app/options.hpp"
#include "host/app/progress.hpp"
#include "host/error.hpp"
#include "host/record/replay.hpp"

namespace lockstep::app {

namespace {

struct VerifyOptions : TargetOptions {
  std::string recording;
  bool quiet = false;
};

void verify(const VerifyOptions& options) {
  const ReplayTarget target = {device_of(options), options.device_options};
  const RecordingReader recording(options.recording);
  if (recording.steps() == 0) throw Error(Failure::input, options.recording, "holds no step yet");
  {
    Progress progress(recording.steps(), !options.quiet);
    const auto done = [&](u32 steps) { progress.update(steps); };
    if (recording.precision() == "double")
      replay<double>(recording, target, done);
    else
      replay<float>(recording, target, done);
  }
  if (options.quiet) return;
  const RecordingLabel& label = recording.label();
  fmt::print("{}, {}, recorded on {}, replayed on {}: {} steps, every state hash equal\n", label.scene,
             recording.precision(), label.device, target.device ? target.device->name : "the reference",
             recording.steps());
  if (recording.outcome() == "running") fmt::print("the run was not over yet, or was killed\n");
}

}  // namespace

void add_verify(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("verify", "Replay a recording and compare the hash of the state after every step");
  const auto options = std::make_shared<VerifyOptions>();
  command->add_option("recording", options->recording, "A file of `lockstep run --record`")->required();
  add_target_options(*command, *options);
  command->add_flag("--quiet", options->quiet, "No progress bar, and no line where all is equal");
  command->footer("Example:\n  lockstep verify heap.h5 --device reference");
  command->callback([options] { verify(*options); });
}

}  // namespace lockstep::app
