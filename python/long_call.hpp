// Calls that may take long: other threads of Python run meanwhile, Ctrl-C is heeded at once, and the interpreter ends
// after them.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "python/bindings.hpp"

namespace lockstep::python {

/// Python's lock is let go of while one of these lives. Where the interpreter has begun to end, threads other than the
/// main one get no further: SystemExit, which ends them without a word.
class Unlocked {
 public:
  Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;
  ~Unlocked();

 private:
  PyThreadState* state_;
};

/// Runs `call` with Python's lock from work that is done without it. A thread whose interpreter has gone meanwhile
/// waits for the end of the process.
void with_lock(const std::function<void()>& call);

/// Work without Python's lock. In the main thread, where signals are heeded, another thread does it: what a signal
/// raises, as Ctrl-C does KeyboardInterrupt, is thrown within 0.05 s, and the work goes on to where it looks whether it
/// was given up.
class LongCall {
 public:
  using Work = std::function<void(const std::atomic<bool>& given_up)>;

  /// Does it, and throws what it throws. `pending` is it as long as it goes on.
  static void run(std::shared_ptr<LongCall>& pending, Work work);
  /// Waits for what is pending, as run() does, and throws what it throws.
  static void finish(std::shared_ptr<LongCall>& pending);
  bool goes_on() const;
  /// Whether it is this thread that does it.
  bool is_mine() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// Whether signals are heeded in this thread.
bool is_main_thread();

/// What `work` gives.
template <class Ask, class Result = std::invoke_result_t<Ask>>
Result run_long(std::shared_ptr<LongCall>& pending, Ask ask) {
  if constexpr (std::is_void_v<Result>) {
    LongCall::run(pending, [ask = std::move(ask)](const auto&) mutable { ask(); });
  } else {
    const auto result = std::make_shared<std::optional<Result>>();
    LongCall::run(pending, [ask = std::move(ask), result](const auto&) mutable { result->emplace(ask()); });
    return std::move(**result);
  }
}

/// The end of the interpreter waits for work that is under way, and then calls `last`; a child of fork() forgets what
/// was under way, and calls `forked`.
void watch_process(std::function<void()> last, std::function<void()> forked);

}  // namespace lockstep::python
