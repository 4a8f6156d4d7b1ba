// A request to end what is under way, as Ctrl-C makes one: a signal handler asks, and what takes long looks between its
// iterations, steps and trials. Only the program asks; it never is in a program that uses the library.
#pragma once

#include <atomic>
#include <stdexcept>

namespace lockstep {

inline std::atomic<bool> stop_is_asked = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

inline void ask_to_stop() { stop_is_asked = true; }
inline bool stop_asked() { return stop_is_asked.load(std::memory_order_relaxed); }

/// Of a step that was given up in its midst; the state is that before it.
class Stopped : public std::runtime_error {
 public:
  Stopped() : std::runtime_error("interrupted") {}
};

}  // namespace lockstep
