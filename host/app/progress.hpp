// A progress bar on stderr for runs of over a second, where stderr is a terminal.
#pragma once

#include <chrono>

#include "kernels/types.h"

namespace lockstep::app {

class Progress {
 public:
  /// `shown`: false keeps it silent whatever stderr is.
  Progress(u32 steps, bool shown);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(u32 steps_done);

 private:
  using Clock = std::chrono::steady_clock;
  u32 steps_;
  bool shown_, drawn_ = false;
  Clock::time_point start_, next_;
};

}  // namespace lockstep::app
