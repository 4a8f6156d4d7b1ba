#include <fmt/format.h>

#include "host/app/command_files.hpp"
#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/mismatch_picture.hpp"
#include "host/app/options.hpp"
#include "host/app/progress.hpp"
#include "host/app/recorded_model.hpp"
#include "host/error.hpp"
#include "host/record/replay.hpp"
#include "host/record/whole_file.hpp"
#include "host/steppers/oracles.hpp"
#include "host/stop_request.hpp"

namespace lockstep::app {

namespace {

struct VerifyOptions : TargetOptions {
  std::string recording, picture;
};

template <class real>
Replayed replay_and_draw(const RecordingReader& recording, const StepTarget& target, const VerifyOptions& options) {
  Progress progress(recording.steps(), !options.quiet);
  u32 equal = 0;
  const auto refuse_rest = [&] {
    throw Error(
        Failure::comparison, options.recording,
        fmt::format("interrupted: of {} steps the state hashes of the first {} are equal", recording.steps(), equal));
  };
  const auto done = [&](u32 steps) {
    progress.update(equal = steps);
    if (Interrupt::asked() && steps < recording.steps()) refuse_rest();
  };
  const auto parting = [&](const Mismatch& mismatch, CheckedBackend<real>& backend) {
    if (options.picture.empty()) return;
    const RecordingLabel& label = recording.label();
    draw_mismatch(mismatch, backend, recorded_model(recording.start<real>(), label), label.scene, options.picture);
  };
  Interrupt::defer();
  try {
    return replay<real>(recording, target, done, parting);
  } catch (const Stopped&) {
    refuse_rest();
    throw;
  }
}

void verify(const VerifyOptions& options) {
  expect_separate({{"--picture", options.picture}}, {{"the recording", options.recording}});
  expect_writable(options.picture, "the picture", png_signature);
  const RecordingReader recording(options.recording);
  const StepTarget target = target_of(options, recording.oracle());
  if (recording.steps() == 0 && recording.outcome() == "running")
    throw Error(Failure::input, options.recording,
                "holds no step: it was cut short before its first one, or has just begun");
  const Replayed replayed = recording.precision() == "double" ? replay_and_draw<double>(recording, target, options)
                                                              : replay_and_draw<float>(recording, target, options);
  if (options.quiet) return;
  const RecordingLabel& label = recording.label();
  const std::string oracle = recording.oracle() ? " by " + recording.oracle().name : "";
  fmt::print(
      "{}, {}{}, recorded on {}, replayed on {}: {} steps, every state hash equal, and all that is stored beside it\n",
      label.scene, recording.precision(), oracle, label.device, replayed.device, recording.steps());
  if (replayed.unsolved.count > 0) fmt::print("{}\n", in_words(recording.oracle().name, replayed.unsolved));
  if (recording.outcome().starts_with("bad: ")) fmt::print("the run was {}\n", recording.outcome());
  if (recording.outcome() == "running") fmt::print("the run was not over yet, or was killed\n");
}

}  // namespace

void add_verify(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "verify", "Replay a recording; compare hash, poses, velocities and measures of every step");
  const auto options = std::make_shared<VerifyOptions>();
  command->add_option("recording", options->recording, "Recording made by `lockstep run --record`")->required();
  add_target_options(*command, *options);
  add_file_option(*command, "--picture", options->picture,
                  "Draw both states in this PNG file if device and reference differ");
  command->add_flag("--quiet", options->quiet, "Print no progress bar, and nothing if all is equal");
  command->footer("Example:\n  lockstep verify heap.h5 --device reference");
  command->callback([options] { verify(*options); });
}

}  // namespace lockstep::app
