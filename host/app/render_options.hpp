// What the command `render` is told.
#pragma once

#include <set>

#include "host/app/frames.hpp"
#include "host/app/options.hpp"
#include "host/app/shown_steps.hpp"

namespace lockstep::app {

struct RenderOptions : SceneOptions {
  FrameOptions frames;
  ShownOptions shown;
  std::string size = "1280x720", color_by = "body";
  std::vector<std::string> show;
  std::vector<double> from, to;
  std::optional<double> fov;
  std::optional<Camera> camera;  // what the three above make
};

void add_render_options(CLI::App& command, RenderOptions& options);

/// What texts stand for. Throws Error (input) where they make no sense, Error (device) where a film cannot be made.
void finish_render_options(const CLI::App& command, RenderOptions& options);

/// Whether the scene that is asked for is a recording.
bool is_recording(const std::string& path);

/// Throws Error (input) where the command line has options other than `own`: the rest is for what is simulated.
void expect_nothing_simulated(const CLI::App& command, const std::string& recording, const std::set<std::string>& own);

/// Throws Error (input) where more is asked of a recording than it holds.
void expect_recording_suffices(const CLI::App& command, const RenderOptions& options);

/// Makes the folder that pictures go to. Throws Error (input) where they cannot be written.
void expect_pictures_writable(const RenderOptions& options, const std::string& scene, u32 first_step);

}  // namespace lockstep::app
