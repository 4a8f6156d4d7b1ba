// Who waits for kernels to be built is told so.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <utility>

namespace lockstep {

/// Adds up how long kernels take to be built, one after another, and says so in one line once that is longer than
/// somebody waits without wondering.
class BuildClock {
 public:
  using Tell = std::function<void(const std::string& line)>;

  /// `tell` may be empty: nobody is told. `patience` in s.
  BuildClock(std::string device, Tell tell, double patience)
      : device_(std::move(device)), tell_(std::move(tell)), patience_(patience) {}

  /// Whether anybody is told.
  bool is_heard() const { return tell_ != nullptr; }

  /// Does the work, which builds kernels.
  template <class Work>
  void time(Work&& work) {
    if (!tell_) return work();
    const auto start = Clock::now();
    work();
    seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
    if (is_told_ || seconds_ <= patience_) return;
    is_told_ = true;
    tell_("building kernels for " + device_ + " takes a while; what is built is kept for the runs to come");
  }

  /// What was wanted has been built: the next time counts by itself.
  void reset() {
    seconds_ = 0;
    is_told_ = false;
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::string device_;
  Tell tell_;
  double patience_, seconds_ = 0;
  bool is_told_ = false;
};

/// Says it on stderr where that is a terminal, as progress bars do.
void tell_on_terminal(const std::string& line);

}  // namespace lockstep
