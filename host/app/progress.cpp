#include "host/app/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <string>

namespace lockstep::app {

namespace {

constexpr u32 bar_width = 40;
constexpr std::chrono::milliseconds patience{1000}, interval{100};

}  // namespace

Progress::Progress(u32 steps, bool shown)
    : steps_(steps), shown_(shown && isatty(STDERR_FILENO) != 0), start_(Clock::now()), next_(start_ + patience) {}

// Leaves the line empty for what is printed next.
Progress::~Progress() {
  if (drawn_) fmt::print(stderr, "\r{:{}}\r", "", bar_width + 60);
}

void Progress::update(u32 steps_done) {
  const Clock::time_point time = Clock::now();
  if (!shown_ || time < next_) return;
  next_ = time + interval;
  drawn_ = true;
  const double share = static_cast<double>(steps_done) / steps_;
  const double seconds = std::chrono::duration<double>(time - start_).count();
  const std::string done(static_cast<std::size_t>(share * bar_width), '#');
  fmt::print(stderr, "\r[{:<{}}] {} of {} steps, {:.0f} s left  ", done, bar_width, steps_done, steps_,
             seconds / share - seconds);
  std::fflush(stderr);
}

}  // namespace lockstep::app
