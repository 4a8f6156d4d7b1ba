#include "host/app/interrupt.hpp"

#include <time.h>
#include <unistd.h>

#include <csignal>

#include "host/stop_request.hpp"

namespace lockstep::app {

namespace {

volatile std::sig_atomic_t is_deferred = 0, asked_by = 0;
timespec asked_at;

// timeout(1), supervisors and terminals send a request twice in a moment: the program, and its group.
constexpr double one_request = 1;  // s

double seconds_between(const timespec& from, const timespec& to) {
  return double(to.tv_sec - from.tv_sec) + 1e-9 * double(to.tv_nsec - from.tv_nsec);
}

extern "C" void take_request(int signal) {
  timespec current;
  clock_gettime(CLOCK_MONOTONIC, &current);
  if (is_deferred == 0) _exit(128 + signal);
  if (asked_by == 0) {
    asked_at = current;
    asked_by = signal;
    ask_to_stop();
  } else if (seconds_between(asked_at, current) > one_request) {
    _exit(128 + signal);
  }
}

}  // namespace

void Interrupt::install() {
  is_deferred = 0;
  struct sigaction action = {};
  action.sa_handler = take_request;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&action.sa_mask, signal);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction inherited = {};
  sigaction(SIGHUP, nullptr, &inherited);
  if (inherited.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);  // nohup(1) has it ignored
}

void Interrupt::defer() { is_deferred = 1; }

bool Interrupt::asked() { return asked_by != 0; }

int Interrupt::status() { return asked_by == 0 ? 0 : 128 + asked_by; }

}  // namespace lockstep::app
