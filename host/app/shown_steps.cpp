#include "host/app/shown_steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/error.hpp"

namespace lockstep::app {

namespace {

constexpr u32 usual_frames = 10;
constexpr double usual_rate = 30;  // pictures a second

std::vector<u32> spread(u32 frames, u32 first, u32 last) {
  std::vector<u32> steps;
  for (u32 i = 0; i < frames; ++i) {
    const double share = frames > 1 ? static_cast<double>(i) / (frames - 1) : 1;
    steps.push_back(first + static_cast<u32>(std::lround(share * (last - first))));
  }
  return steps;
}

std::vector<u32> by_time(double rate, u32 first, u32 last, double dt) {
  std::vector<u32> steps;
  const double stride = 1 / (rate * dt);
  for (u32 i = 0;; ++i) {
    const double at = std::round(first + i * stride);  // a dt in float is a little off: the last one counts
    if (at > last) break;
    steps.push_back(static_cast<u32>(at));
  }
  return steps;
}

}  // namespace

void add_shown_options(CLI::App& command, ShownOptions& options) {
  const std::string group = "Steps to show";
  CLI::Option* at = command.add_option("--at", options.at, "Show these steps, such as 0,120,600")->delimiter(',');
  CLI::Option* frames =
      command.add_option("--frames", options.frames, "Show this many steps, evenly spaced over the run");
  CLI::Option* every = command.add_option("--every", options.every, "Show every Nth step, from the first");
  CLI::Option* fps = command.add_option(
      "--fps", options.fps,
      "Pictures per second of film; without the options above, of simulated time (real-time playback)");
  for (CLI::Option* option : {at, frames, every, fps}) option->group(group);
  at->check(CLI::NonNegativeNumber);
  frames->check(CLI::Range(1, 1000000))->excludes(at);
  every->check(CLI::Range(1, 1000000000))->excludes(at)->excludes(frames);
  fps->check(finite)->check(CLI::Range(0.001, 1000.0));
}

double film_rate(const ShownOptions& options, double dt) {
  if (options.fps) return *options.fps;
  const bool chosen = !options.at.empty() || options.frames || options.every;
  return chosen ? usual_rate : std::min(usual_rate, 1 / dt);
}

std::vector<u32> shown_steps(const ShownOptions& options, u32 first, u32 last, double dt, bool film) {
  std::vector<u32> steps;
  if (!options.at.empty()) {
    steps = options.at;
    std::sort(steps.begin(), steps.end());
    for (const u32 step : steps) {
      if (step < first || step > last)
        throw Error(Failure::input, "--at", fmt::format("there is no step {} here, only {} to {}", step, first, last));
    }
  } else if (options.frames) {
    steps = spread(*options.frames, first, last);
  } else if (options.every) {
    for (std::uint64_t step = first; step <= last; step += *options.every) steps.push_back(static_cast<u32>(step));
  } else if (options.fps || film) {
    if (options.fps && *options.fps * dt > 1 + 1e-9)
      throw Error(Failure::input, "--fps",
                  fmt::format("there are only {:.4g} steps in a second of simulated time; ask for no more pictures, or "
                              "choose steps with --every or --frames",
                              1 / dt));
    steps = by_time(film_rate(options, dt), first, last, dt);
  } else {
    steps = spread(usual_frames, first, last);
  }
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  return steps;
}

}  // namespace lockstep::app
