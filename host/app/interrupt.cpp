#include "host/app/interrupt.hpp"

#include <time.h>

#include <csignal>

namespace lockstep::app {

namespace {

volatile std::sig_atomic_t asked_to_end = 0;
timespec asked_at;

// timeout(1), supervisors and terminals send a request twice in a moment: the program, and its group.
constexpr double one_request = 1;  // s

extern "C" void ask_to_end(int signal) {
  timespec current;
  clock_gettime(CLOCK_MONOTONIC, &current);
  if (asked_to_end == 0) {
    asked_at = current;
    asked_to_end = 1;
  } else if (double(current.tv_sec - asked_at.tv_sec) + 1e-9 * double(current.tv_nsec - asked_at.tv_nsec) >
             one_request) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

Interrupt::Interrupt() {
  std::signal(SIGINT, ask_to_end);
  std::signal(SIGTERM, ask_to_end);
}

// What a run that was asked to end still has to write is not lost to the same request either.
Interrupt::~Interrupt() {
  if (asked()) return;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool Interrupt::asked() { return asked_to_end != 0; }

}  // namespace lockstep::app
