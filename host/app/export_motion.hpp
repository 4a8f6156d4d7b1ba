// `lockstep export` of a motion: where bodies are over time, for programs that show and edit scenes.
#pragma once

#include "host/app/options.hpp"

namespace lockstep::app {

struct MotionOptions : SceneOptions {
  std::string output;
  std::optional<double> fps;  // keyframes a second of simulated time
};

/// Whether a file of this name is to be a motion.
bool is_motion(const std::string& output);

/// Of a recording as it is, of a scene by simulating it. Throws Error (input) where `command` has options that do not
/// go with that.
void export_motion(const CLI::App& command, const MotionOptions& options);

}  // namespace lockstep::app
