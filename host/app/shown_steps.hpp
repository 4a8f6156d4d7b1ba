// Which steps of a run are shown.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "kernels/types.h"

namespace lockstep::app {

struct ShownOptions {
  std::vector<u32> at;        // these steps
  std::optional<u32> frames;  // so many, evenly spread, both ends among them
  std::optional<u32> every;   // each so many steps, from the first
  std::optional<double> fps;  // of a film; where nothing else is asked for, of simulated time
};

void add_shown_options(CLI::App& command, ShownOptions& options);

/// Steps to show, in order: numbers of steps that are done, from `first` (the state that a run begins with) to `last`.
/// Without a choice ten, or 30 a second for a film. Throws Error (input) for steps that there are not. `dt` is that of
/// a step, s.
std::vector<u32> shown_steps(const ShownOptions& options, u32 first, u32 last, double dt, bool film);

/// Pictures a second that a film of these plays.
double film_rate(const ShownOptions& options, double dt);

}  // namespace lockstep::app
